#include "benchmarks/tools/calibrate/run_judgement.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include "sim/imaging/exif.h"

namespace cousin {
namespace {

std::string three_digits(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

}  // namespace

void warn_of_turned_photos(CalibrationRun& run) {
  for (int orientation = 2; orientation <= 8; ++orientation) {
    const CalibrationPhoto* first = nullptr;
    int count = 0;
    for (const CalibrationPhoto& photo : run.photos.photos) {
      if (photo.exif_orientation != orientation) continue;
      if (first == nullptr) first = &photo;
      ++count;
    }
    if (count == 0) continue;
    run.warnings.push_back(
        std::to_string(count) + " of " + std::to_string(run.photos.photos.size()) + " images (" +
        first->name + " first) have the EXIF orientation " + std::to_string(orientation) +
        ": a viewer " + std::string(orientation_text(orientation)) +
        ". Pixels are used as they are stored, so the cameras fit the stored pixels. cv::imread "
        "turns such images: read them with IMREAD_IGNORE_ORIENTATION");
  }
}

void judge(CalibrationRun& run) {
  const CalibrateConfig& config = run.config;
  const bool several = run.photos.cameras.size() > 1;
  if (run.result.status != CalibrationStatus::ok)
    run.problems.push_back(std::string(to_string(run.result.status)) + ": " + run.result.reason);
  for (std::size_t c = 0; c < run.verdicts.size(); ++c) {
    const CameraVerdict& v = run.verdicts[c];
    const std::string who = several ? run.photos.cameras[c] + ": " : "";
    if (v.rms_px > config.most_rms_px && v.rms_px > config.most_rms_sigmas * v.predicted_px) {
      run.problems.push_back(who + "the lens model " + std::string(to_string(config.model)) +
                             " does not fit: residuals of " + three_digits(v.rms_px) +
                             " px RMS where detection predicts " + three_digits(v.predicted_px) +
                             "; try a richer model, or kannala_brandt4 for a fisheye");
    }
    if (v.tilt_spread_rad < config.least_tilt_spread_rad) {
      run.warnings.push_back(
          who + "the boards are nearly parallel: " +
          three_digits(v.tilt_spread_rad * 180 / std::numbers::pi) +
          " degrees at most between two; focal length and distance cannot be told apart");
    }
    const double width_px = run.result.cameras[c].width_px;
    const std::string known = "the projection's deviation is " + three_digits(v.deviation_px) +
                              " px, the median over the image";
    if (v.deviation_px > config.most_deviation_share * width_px) {
      run.problems.push_back(who + known + "; the limit is " +
                             three_digits(config.most_deviation_share * width_px) + " px");
    } else if (v.deviation_px > config.warn_deviation_share * width_px) {
      run.warnings.push_back(who + known + "; " +
                             std::to_string(static_cast<int>(std::lround(100 * v.valid_share))) +
                             " % of the image is valid");
    }
    constexpr double kLeastCoverage = 0.35;
    if (v.coverage < kLeastCoverage) {
      run.warnings.push_back(who + "points cover " +
                             std::to_string(static_cast<int>(std::lround(100 * v.coverage))) +
                             " % of the image: the lens is extrapolated beyond them");
    }
  }
  constexpr double kTimesPredicted = 2;
  if (run.cross && run.cross->difference.rms_px > kTimesPredicted * run.cross->predicted_rms_px) {
    run.warnings.push_back("calibrated from either half of the images, projections differ by " +
                           three_digits(run.cross->difference.rms_px) + " px RMS where " +
                           three_digits(run.cross->predicted_rms_px) +
                           " is predicted: the lens model or the board is not as assumed");
  }
  if (run.result.outliers > 0) {
    run.warnings.push_back(
        std::to_string(run.result.outliers) + " of " + std::to_string(run.result.observations) +
        " points lie more than ten robust deviations off and pull at the result: "
        "--set calibration.reject_sigmas=5 leaves wrong detections out");
  }
  for (const std::string& name : run.result.not_determined)
    run.warnings.push_back(name + " cannot be determined from these views");
  const auto refused = std::count_if(run.input.views.begin(), run.input.views.end(),
                                     [](const TargetView& view) { return !is_usable(view); });
  if (refused > 0) {
    run.warnings.push_back("no board was used in " + std::to_string(refused) + " of " +
                           std::to_string(run.input.views.size()) + " images");
  }
}

}  // namespace cousin
