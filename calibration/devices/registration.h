#pragma once

#include <Eigen/Core>
#include <limits>
#include <string_view>
#include <vector>

#include "calibration/solve/calibrate.h"
#include "sim/config/fields.h"
#include "sim/types/camera.h"
#include "sim/types/pose.h"

namespace cousin {

/// How a depth camera's pixels are brought to its colour image. Depth is in the pixels of one of
/// its infrared imagers.
struct DepthRegistration {
  Camera depth, color;
  Pose color_from_depth;
};
/// Of two cameras of a rig that were calibrated together.
/// @throws std::invalid_argument for a camera that does not exist
DepthRegistration registration_of(const CalibrationResult& result, int depth_camera,
                                  int color_camera);

/// The colour pixel of a depth pixel at a depth along its axis; NaN where either lens has none.
Eigen::Vector2d registered_px(const DepthRegistration& registration,
                              const Eigen::Vector2d& depth_px, double depth_m);

struct RegistrationConfig {
  double distance_m = 0.6;      ///< working distance, along the depth camera's axis
  int columns = 16, rows = 12;  ///< of depth pixels over the image, its border included
  double least_gain_px = 0.1;   ///< of error that a new calibration is worth taking over for
};

Fields fields(RegistrationConfig& config);
void validate(const RegistrationConfig& config);

/// `keep`: what is there is as good as the new calibration, or its error is below `least_gain_px`;
/// `replace`: its error exceeds that and the new calibration's; `cannot_tell`: the new calibration
/// is not sure enough, so that more views are needed. Each at two deviations.
enum class RegistrationVerdict { keep, replace, cannot_tell };
std::string_view to_string(RegistrationVerdict verdict);

/// Is recalibrating worth it? The colour pixels that a registration from the factory gives, less
/// those of a fresh one, for the same depth pixels and depths, and what the fresh one's covariance
/// leaves unsure. Neither says anything of the depth's own bias (depth_bias.h).
struct RegistrationDifference {
  int columns = 0, rows = 0;
  std::vector<Eigen::Vector2d> depth_px;        ///< row by row
  std::vector<Eigen::Vector2d> difference_px;   ///< NaN where either has none
  std::vector<Eigen::Matrix2d> covariance_px2;  ///< of the fresh calibration; NaN likewise
  double rms_px = std::numeric_limits<double>::quiet_NaN();  ///< of the difference's length
  double max_px = std::numeric_limits<double>::quiet_NaN();
  double fresh_rms_px = std::numeric_limits<double>::quiet_NaN();  ///< expected error of the fresh
  /// The factory's own error, the fresh one's taken off: root of rms^2 - fresh_rms^2, 0 where that
  /// is negative; and the deviation of its square.
  double factory_rms_px = std::numeric_limits<double>::quiet_NaN();
  double factory_square_sigma_px2 = std::numeric_limits<double>::quiet_NaN();
  RegistrationVerdict verdict = RegistrationVerdict::cannot_tell;
};

/// First order in the fresh calibration's parameters, lenses and places together.
/// @throws std::invalid_argument for an invalid config, a camera that does not exist, a result
/// without covariance, or a factory registration whose depth image is of another size
RegistrationDifference registration_difference(const DepthRegistration& factory,
                                               const CalibrationResult& fresh, int depth_camera,
                                               int color_camera,
                                               const RegistrationConfig& config = {});

}  // namespace cousin
