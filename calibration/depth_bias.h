#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "calibration/calibrate.h"

namespace cousin {

/// What a depth camera measured where a plane of known pose is.
struct DepthSample {
  Eigen::Vector2d pixel_px;
  double measured_m = 0;  ///< along the optical axis
  double true_m = 0;      ///< of the plane there
};

/// measured = true + offset_m + scale true + bowl r^2 true + disparity_shift true^2, where r is the
/// pixel's distance from the image's middle over half its diagonal. A shift of the disparity by b
/// pixels is true^2 b / (f B).
struct DepthBiasConfig {
  bool offset = true, scale = true, bowl = true;
  bool disparity_shift = false;
  double reject_sigmas = 4;       ///< of a robust deviation; 0 = none
  double max_deviation_m = 2e-3;  ///< of the bias at the middle of the samples' depths
};
Fields fields(DepthBiasConfig& config);
void validate(const DepthBiasConfig& config);

struct DepthBias {
  CalibrationStatus status = CalibrationStatus::not_converged;
  std::string reason;
  std::vector<std::string> not_determined;  ///< terms
  double offset_m = 0;
  double scale = 0;
  double bowl = 0;
  double disparity_shift_per_m = 0;
  std::vector<std::string> terms;  ///< those solved for, in the order of the covariance
  Eigen::MatrixXd covariance;      ///< neighbouring pixels' noise counted as independent
  double rms_m = std::numeric_limits<double>::quiet_NaN();  ///< what is left
  int samples = 0, rejected = 0;
};

/// Least squares over samples of planes at several distances. One distance cannot tell offset from
/// scale, nor a small patch the bowl: then the terms are named. Not finite samples are passed over.
[[nodiscard]] DepthBias fit_depth_bias(const std::vector<DepthSample>& samples, int width_px,
                                       int height_px, const DepthBiasConfig& config = {});

/// Depth with the bias taken out; NaN stays NaN.
double corrected_depth_m(const DepthBias& bias, const Eigen::Vector2d& pixel_px, double measured_m,
                         int width_px, int height_px);

/// Depth along the axis at a pixel of the target's plane z = 0; NaN where the ray misses it.
double plane_depth_m(const Camera& camera, const Pose& camera_from_target,
                     const Eigen::Vector2d& pixel_px);

}  // namespace cousin
