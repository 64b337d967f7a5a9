#include "benchmarks/tools/calibrate/device_output.h"

#include <cmath>
#include <cstdio>

#include "benchmarks/report/shown_numbers.h"

namespace cousin {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

std::string line_of(const char* format, auto... values) {
  char text[256];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

bool has_line_delay(const CalibrationRun& run) {
  return run.rolling && std::isfinite(run.rolling->line_delay_s);
}

/// NaN: the line delay was given, not solved for.
double line_delay_deviation_s(const CalibrationRun& run) {
  return has_line_delay(run) ? deviation(run.result, "camera0.line_delay_s") : std::nan("");
}

/// " +- 0.2", or nothing of what was given.
std::string plus_minus(double deviation) {
  return std::isfinite(deviation) ? line_of(" +- %.2g", deviation) : std::string(", as given");
}

/// From first to last row, of the line delay.
double rows_of(const CalibrationRun& run) { return run.result.cameras.front().height_px - 1.0; }

/// What the device says of it; NaN without.
double reported_readout_s(const CalibrationRun& run) {
  return run.photos.reported.empty() || run.photos.reported.front().shutter != Shutter::rolling
             ? std::nan("")
             : run.photos.reported.front().readout_s;
}

Json rolling_json(const CalibrationRun& run) {
  return {{"line_delay_s", number(run.rolling->line_delay_s)},
          {"deviation_s", number(line_delay_deviation_s(run))},
          {"reported_readout_s", number(reported_readout_s(run))},
          {"neighbouring_views", run.rolling->neighbours}};
}

Json registration_json(const RegistrationDifference& d) {
  return {{"verdict", to_string(d.verdict)},
          {"rms_px", number(d.rms_px)},
          {"max_px", number(d.max_px)},
          {"fresh_rms_px", number(d.fresh_rms_px)},
          {"reported_rms_px", number(d.factory_rms_px)},
          {"reported_square_deviation_px2", number(d.factory_square_sigma_px2)}};
}

Json depth_json(const CalibrationRun& run) {
  const DepthCheck& d = *run.depth;
  Json json{{"verdict", to_string(d.verdict)},
            {"reason", d.reason},
            {"distance_m", run.config.depth.distance_m},
            {"mean_m", number(d.mean_m)},
            {"rms_m", number(d.rms_m)},
            {"spread_m", number(d.spread_m)},
            {"fresh_m", number(d.fresh_m)},
            {"error_m", number(d.error_m)},
            {"error_square_deviation_m2", number(d.error_square_sigma_m2)},
            {"views", d.views},
            {"nearest_m", number(d.nearest_m)},
            {"farthest_m", number(d.farthest_m)}};
  json["bias"] = {{"status", to_string(d.bias.status)},
                  {"terms", d.bias.terms},
                  {"offset_m", d.bias.offset_m},
                  {"scale", d.bias.scale},
                  {"bowl", d.bias.bowl},
                  {"disparity_shift_per_m", d.bias.disparity_shift_per_m},
                  {"ripple_sin_px", d.bias.ripple_sin_px},
                  {"ripple_cos_px", d.bias.ripple_cos_px},
                  {"rms_m", number(d.bias.rms_m)},
                  {"samples", d.bias.samples},
                  {"rejected", d.bias.rejected}};
  return json;
}

std::string registration_text(const CalibrationRun& run) {
  const RegistrationDifference& d = *run.registration;
  const std::string what = d.verdict == RegistrationVerdict::replace ? "worth replacing by this one"
                           : d.verdict == RegistrationVerdict::keep
                               ? "as good as this one, or nearly"
                               : "open: this calibration is not sure enough, take more images";
  return line_of(
             "\nreported registration of depth to colour, at %.2f m: differs by %.3f px RMS, "
             "%.3f px at most;\n  this one is sure to %.3f px; the reported one is ",
             run.config.registration.distance_m, d.rms_px, d.max_px, d.fresh_rms_px) +
         what + "\n";
}

/// What to do about the depth.
std::string advice(const DepthCheck& d, double least_gain_m) {
  if (d.verdict == DepthVerdict::correct) return "worth correcting by the terms found";
  if (d.verdict == DepthVerdict::keep)
    return line_of("below the %.3g mm that a correction is worth", 1000 * least_gain_m);
  return "open: " + d.reason;
}

std::string depth_text(const CalibrationRun& run) {
  const DepthCheck& d = *run.depth;
  std::string text = line_of("\ndepth on %d boards, ", d.views);
  if (std::isfinite(d.rms_m)) {
    text += line_of(
        "%.3g to %.3g m away: at %.2f m it is %+.3f mm off in the mean, %.3f mm RMS over the "
        "image;\n  boards are sure of that to %.3f mm, this calibration to %.3f mm; the error is ",
        d.nearest_m, d.farthest_m, run.config.depth.distance_m, 1000 * d.mean_m, 1000 * d.rms_m,
        1000 * d.spread_m, 1000 * d.fresh_m);
  } else {
    text += "its error is ";
  }
  return text + advice(d, run.config.depth.least_gain_m) + "\n";
}

}  // namespace

void add_device(const CalibrationRun& run, Json& json) {
  if (run.rolling) json["rolling_shutter"] = rolling_json(run);
  if (run.registration) json["registration"] = registration_json(*run.registration);
  if (run.depth) json["depth"] = depth_json(run);
}

std::string device_table(const CalibrationRun& run) {
  std::string text;
  if (has_line_delay(run)) {
    text += line_of("\nline delay %.4g us a row%s, by %d pairs of neighbouring pictures\n",
                    1e6 * run.rolling->line_delay_s,
                    plus_minus(1e6 * line_delay_deviation_s(run)).c_str(), run.rolling->neighbours);
    if (std::isfinite(reported_readout_s(run)))
      text += line_of("  first to last row %.4g ms%s; the device reports %.4g ms\n",
                      1e3 * rows_of(run) * run.rolling->line_delay_s,
                      plus_minus(1e3 * rows_of(run) * line_delay_deviation_s(run)).c_str(),
                      1e3 * reported_readout_s(run));
  }
  if (run.registration) text += registration_text(run);
  if (run.depth) text += depth_text(run);
  return text;
}

std::string device_sentences(const CalibrationRun& run) {
  std::string text;
  if (has_line_delay(run)) {
    text += " Rows are read one after the other, " + shown_number(1e6 * run.rolling->line_delay_s) +
            " us apart" +
            (std::isfinite(line_delay_deviation_s(run))
                 ? ", sure to " + shown_number(1e6 * line_delay_deviation_s(run)) + " us."
                 : std::string(", as given."));
  }
  if (run.registration) {
    text += " The device's own registration of depth to colour differs by " +
            shown_number(run.registration->rms_px) + " px RMS at " +
            shown_number(run.config.registration.distance_m) + " m, where this one is sure to " +
            shown_number(run.registration->fresh_rms_px) + " px: verdict \"" +
            std::string(to_string(run.registration->verdict)) + "\".";
  }
  if (run.depth) {
    const DepthCheck& d = *run.depth;
    text += " The device's depth on the boards";
    if (std::isfinite(d.rms_m)) {
      text += " is off by " + shown_number(1000 * d.rms_m) + " mm RMS over the image at " +
              shown_number(run.config.depth.distance_m) + " m, sure to " +
              shown_number(1000 * std::hypot(d.spread_m, d.fresh_m)) + " mm";
    }
    text += ": verdict \"" + std::string(to_string(d.verdict)) + "\"" +
            (d.reason.empty() ? "." : ", " + d.reason + ".");
  }
  return text;
}

}  // namespace cousin
