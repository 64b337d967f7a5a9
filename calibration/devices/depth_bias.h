#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "calibration/solve/calibrate.h"

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
///
/// A stereo camera's disparity d = f B / true may also be read off by a ripple with the period of a
/// pixel, d + s sin(2 pi d) + c cos(2 pi d), which is measured - true = -true^2 / (f B) of that.
struct DepthBiasConfig {
  bool offset = true, scale = true, bowl = true;
  bool disparity_shift = false;
  bool ripple = false;                    ///< s and c; needs f B
  double focal_baseline_px_m = 0;         ///< f B of the depth's pixels, from the rig; 0: unknown
  double max_ripple_deviation_px = 0.03;  ///< of s and c, above which they are not determined
  double reject_sigmas = 4;               ///< of a robust deviation; 0 = none
  double max_deviation_m = 2e-3;          ///< of the bias at the middle of the samples' depths
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
  double ripple_sin_px = 0, ripple_cos_px = 0;  ///< s and c
  double focal_baseline_px_m = 0;               ///< that they belong to; 0 without ripple
  std::vector<std::string> terms;  ///< those solved for, in the order of the covariance
  Eigen::MatrixXd covariance;      ///< neighbouring pixels' noise counted as independent
  double rms_m = std::numeric_limits<double>::quiet_NaN();  ///< what is left
  int samples = 0, rejected = 0;
};

/// The ripple as A sin(2 pi d + phase), with first-order deviations.
struct DepthRipple {
  double amplitude_px = 0, amplitude_sigma_px = 0;
  double phase_rad = 0, phase_sigma_rad = 0;
};
/// @throws std::invalid_argument if `bias` was fitted without ripple or is not ok
DepthRipple ripple_of(const DepthBias& bias);

/// Least squares over samples of planes at several distances. One distance cannot tell offset from
/// scale, nor a small patch the bowl: then the terms are named; nor do planes tell a ripple whose
/// disparities leave two fifths of the pixel's period out, or an amplitude of 1 / (2 pi) px or
/// more, where depth would no longer grow with distance. Not finite samples are passed over.
/// @throws std::invalid_argument for an invalid config, as with ripple and without f B
[[nodiscard]] DepthBias fit_depth_bias(const std::vector<DepthSample>& samples, int width_px,
                                       int height_px, const DepthBiasConfig& config = {});

/// Depth with the bias taken out; NaN stays NaN, and NaN is a depth that no distance is measured
/// as.
double corrected_depth_m(const DepthBias& bias, const Eigen::Vector2d& pixel_px, double measured_m,
                         int width_px, int height_px);

/// What is measured where `true_m` is: the inverse of corrected_depth_m.
double biased_depth_m(const DepthBias& bias, const Eigen::Vector2d& pixel_px, double true_m,
                      int width_px, int height_px);

/// Depth along the axis at a pixel of the target's plane z = 0; NaN where the ray misses it.
double plane_depth_m(const Camera& camera, const Pose& camera_from_target,
                     const Eigen::Vector2d& pixel_px);

}  // namespace cousin
