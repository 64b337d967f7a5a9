#include "calibration/solve/calibration_judgement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "calibration/solve/calibration_uncertainty.h"

namespace cousin {
namespace {

void add_once(std::vector<std::string>& names, const std::string& name) {
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

/// Deviations that are finite but larger than a calibration is worth.
void check_deviations(const CalibrationInput& input, const CalibrationConfig& config,
                      CalibrationResult& result) {
  std::ostringstream why;
  for (std::size_t c = 0; c < result.cameras.size(); ++c) {
    const Camera& camera = result.cameras[c];
    const std::string prefix = "camera" + std::to_string(c) + ".";
    if (parameter_index(result, prefix + "fx_px") < 0 && camera.spline.columns == 0 && c > 0 &&
        input.cameras[c].shares_lens_with >= 0)
      continue;
    const auto over = [&](const char* name, double limit) {
      const double sigma = deviation(result, prefix + name);
      if (!(sigma > limit)) return;
      add_once(result.not_determined, prefix + name);
      why << prefix << name << " has a deviation of " << sigma << " (at most " << limit << "); ";
    };
    over("fx_px", config.max_focal_share * camera.fx_px);
    over("fy_px", config.max_focal_share * camera.fy_px);
    over("cx_px", config.max_centre_share * camera.width_px);
    over("cy_px", config.max_centre_share * camera.width_px);
    const UncertaintyMap map = projection_uncertainty(result, static_cast<int>(c));
    UncertaintyMap counted = map;
    if (camera.model == LensModel::splined_stereographic) {
      const ValidRegion seen = valid_region(result, input, static_cast<int>(c), map,
                                            std::numeric_limits<double>::infinity());
      for (std::size_t i = 0; i < seen.valid.size(); ++i) {
        if (!seen.valid[i])
          counted.covariance_px2[i].setConstant(std::numeric_limits<double>::quiet_NaN());
      }
    }
    const double rms = rms_deviation_px(counted);
    const double limit = config.max_deviation_share * camera.width_px;
    if (!(rms > limit)) continue;
    why << prefix << "projection has a deviation of " << rms << " px over the image (at most "
        << limit << "); ";
    for (const std::string& name : result.parameters) {
      const bool of_lens = name.rfind(prefix, 0) == 0 && name.find(".r_") == std::string::npos &&
                           name.find(".t_") == std::string::npos;
      if (of_lens) add_once(result.not_determined, name);
    }
  }
  if (result.reason.empty()) result.reason = why.str();
}

/// Whether a fisheye folds only well beyond all that was seen: the corners outside its image circle
/// have no light, and nothing there can be calibrated.
bool folds_in_the_dark(const CalibrationInput& input, const CalibrationResult& result,
                       std::size_t camera) {
  const Lens lens(result.cameras[camera]);
  if (lens.camera().model != LensModel::kannala_brandt4) return false;
  constexpr double kMargin = 0.95;
  for (const TargetView& view : input.views) {
    if (!is_usable(view) || view.camera != static_cast<int>(camera)) continue;
    for (const TargetObservation& point : view.points) {
      const auto way = lens.unproject(point.pixel_px);
      if (!way || std::acos(std::clamp(way->z(), -1.0, 1.0)) > kMargin * lens.monotone_limit())
        return false;
    }
  }
  return true;
}

/// A lens that folds inside its image is no calibration of that image.
void check_folding(const CalibrationInput& input, CalibrationResult& result) {
  for (std::size_t c = 0; c < result.cameras.size(); ++c) {
    try {
      validate(result.cameras[c]);
    } catch (const std::invalid_argument& error) {
      if (result.cameras[c].model == LensModel::splined_stereographic ||
          folds_in_the_dark(input, result, c))
        continue;
      const std::string prefix = "camera" + std::to_string(c) + ".";
      for (const std::string& name : result.parameters) {
        const bool distortion = name.rfind(prefix + "k", 0) == 0 ||
                                name.rfind(prefix + "p", 0) == 0 ||
                                name.rfind(prefix + "s", 0) == 0;
        if (distortion) add_once(result.not_determined, name);
      }
      if (result.not_determined.empty()) add_once(result.not_determined, prefix + "fx_px");
      if (result.reason.empty()) result.reason = error.what();
    }
  }
}

}  // namespace

void judge_calibration(const CalibrationInput& input, const CalibrationConfig& config,
                       CalibrationResult& result) {
  check_folding(input, result);
  if (result.not_determined.empty()) check_deviations(input, config, result);
  // What is open keeps a solver from converging, too: that is then the reason.
  if (!result.not_determined.empty()) result.status = CalibrationStatus::not_determined;
}

}  // namespace cousin
