// calibration_output.h's report page.

#include <cmath>
#include <numbers>

#include "benchmarks/report/report.h"
#include "benchmarks/report/shown_numbers.h"
#include "benchmarks/score/distributions.h"
#include "benchmarks/tools/calibrate/calibration_output.h"
#include "benchmarks/tools/calibrate/calibration_pictures.h"
#include "benchmarks/tools/calibrate/device_output.h"
#include "sim/config/fields.h"
#include "sim/dataset/atomic_file.h"
#include "sim/imaging/image_io.h"

namespace cousin {
namespace {

void add_headlines(const CalibrationRun& run, ReportInput& input) {
  const auto add = [&](const std::string& label, double value, const std::string& unit,
                       double sigma = std::nan("")) {
    const double half = kSigmas95 * sigma;
    input.headlines.push_back(
        {label, {value, value - half, value + half}, unit, "", ScoreStatus::ok, ""});
  };
  const bool several = run.verdicts.size() > 1;
  for (std::size_t c = 0; c < run.verdicts.size(); ++c) {
    const std::string who = several ? run.photos.cameras[c] + ", " : "";
    const std::string prefix = "camera" + std::to_string(c) + ".";
    const Camera& lens = run.result.cameras[c];
    add(who + "fx", lens.fx_px, "px", deviation(run.result, prefix + "fx_px"));
    add(who + "fy", lens.fy_px, "px", deviation(run.result, prefix + "fy_px"));
    add(who + "residual RMS", run.verdicts[c].rms_px, "px");
    if (!run.verdicts[c].uncertainty.covariance_px2.empty())
      add(who + "projection's deviation, median", run.verdicts[c].deviation_px, "px");
    if (c == 0 && run.rolling && std::isfinite(run.rolling->line_delay_s))
      add("line delay", run.rolling->line_delay_s, "s",
          deviation(run.result, prefix + "line_delay_s"));
    if (c > 0) add(who + "baseline", run.result.camera_from_rig[c].translation_m.norm(), "m");
  }
}

void add_pictures(const CalibrationRun& run, ReportInput& input) {
  for (std::size_t c = 0; c < run.verdicts.size(); ++c) {
    const int camera = static_cast<int>(c);
    const CameraVerdict& v = run.verdicts[c];
    const std::string who = run.photos.cameras[c] + ": ";
    std::string next = "Green: points used; red: rejected.";
    if (v.next) {
      next += " Blue: where to hold the board next: " + v.next->words +
              ". It takes the "
              "projection's deviation from " +
              shown_number(v.next->now_px) + " px to " + shown_number(v.next->then_px) + " px RMS.";
    }
    input.images.push_back({who + "coverage", next, encode_png(coverage_picture(run, camera))});
    const ResidualPicture residuals = residual_picture(run, camera);
    input.images.push_back(
        {who + "residuals",
         "Colour: RMS a coordinate in each cell, dark 0, yellow three times the " +
             shown_number(v.predicted_px) + " px that detection predicts. Lines: mean residual, " +
             shown_number(residuals.pixels_per_px) +
             " times as long. A pattern means that the lens model or the board is not as assumed.",
         encode_png(residuals.image)});
    const UncertaintyPicture uncertainty = uncertainty_picture(run, camera);
    if (!uncertainty.image.empty()) {
      input.images.push_back({who + "uncertainty",
                              "Deviation of the projection along its worst direction, points at "
                              "infinity, the camera's rotation free: dark " +
                                  shown_number(uncertainty.least_px) + " px, yellow " +
                                  shown_number(uncertainty.most_px) + " px, by logarithm.",
                              encode_png(uncertainty.image)});
    }
  }
  const DepthPicture depth = depth_picture(run);
  if (!depth.image.empty()) {
    input.images.push_back({"depth on the boards",
                            "Measured less true depth in each cell, the median, brought to " +
                                shown_number(run.config.depth.distance_m) +
                                " m by the square of the distance: dark blue " +
                                shown_number(-1000 * depth.most_m) + " mm, green 0, yellow " +
                                shown_number(1000 * depth.most_m) + " mm.",
                            encode_png(depth.image)});
  }
}

}  // namespace

void write_calibration_report(const std::filesystem::path& file, const CalibrationRun& run,
                              const ScoreFile& scores, const std::string& command_line) {
  ReportInput input;
  input.title = "Cousin: calibrate";
  input.summary = std::string(run.problems.empty() ? "Calibrated"
                                                   : "Refused: do not use these numbers. Tried") +
                  " from " + to_text(run.photos.target) +
                  (has_two_layouts(run.photos.target) && run.photos.layout
                       ? " (layout " + std::string(to_string(*run.photos.layout)) + ")"
                       : "") +
                  " in " + std::to_string(run.input.views.size()) +
                  " images. Intervals are of 95 %, from the solver's covariance: they hold if the "
                  "lens model and "
                  "the board are as assumed, which small residuals do not prove.";
  if (run.cross) {
    input.summary += " Calibrated from either half of the images alone, projections differ by " +
                     shown_number(run.cross->difference.rms_px) + " px RMS, where " +
                     shown_number(run.cross->predicted_rms_px) + " px is predicted.";
  }
  input.summary += device_sentences(run);
  if (!command_line.empty()) input.commands = {command_line};
  CalibrateConfig config = run.config;
  input.config_toml = to_toml(fields(config));
  input.scores = scores;
  for (const std::string& problem : run.problems) input.notes.push_back("Refused: " + problem);
  for (const std::string& warning : run.warnings) input.notes.push_back(warning);
  for (std::size_t i = 0; i < run.input.views.size(); ++i) {
    if (!is_usable(run.input.views[i]))
      input.notes.push_back(run.photos.photos[i].name + ": " + run.input.views[i].reason);
  }
  add_headlines(run, input);
  add_pictures(run, input);
  write_file(file, make_report(input));
}

}  // namespace cousin
