#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/devices/depth_bias.h"
#include "calibration/solve/calibrate.h"
#include "sim/config/fields.h"
#include "sim/types/calibration_target.h"
#include "sim/types/image.h"

namespace cousin {

/// Stereo errs by a scale (focal length, baseline), a shift of its disparity (the imagers' yaw) and
/// a bowl (lenses); a constant has no cause there.
struct DepthCheckConfig {
  double distance_m = 0.6;  ///< working distance, along the depth camera's axis
  /// Between samples, and of them from the print's border: farther than a matcher's window reaches.
  int step_px = 12;
  int columns = 16, rows = 12;   ///< of pixels over the image that the bias is judged at
  double least_gain_m = 0.0005;  ///< of error that a correction is worth
  int least_views = 6;           ///< boards whose spread tells the deviation
  DepthBiasConfig bias{.offset = false, .disparity_shift = true};
};
Fields fields(DepthCheckConfig& config);
void validate(const DepthCheckConfig& config);

/// `keep`: the error at the working distance is below `least_gain_m`; `correct`: it exceeds that;
/// `cannot_tell`: boards and calibration leave that open. Each at two deviations.
enum class DepthVerdict { keep, correct, cannot_tell };
std::string_view to_string(DepthVerdict verdict);

/// What a depth camera measured on one board.
struct DepthView {
  int frame = 0;
  std::vector<DepthSample> samples;
};

/// Every `step_px` pixel of a depth image (metres along the axis, NaN = none; of the camera's size)
/// whose ray meets the print, `step_px` pixels away from its border.
/// @throws std::invalid_argument for an image of another size than the camera's
std::vector<DepthSample> depth_on_target(const Image<float>& depth_m, const Camera& camera,
                                         const Pose& camera_from_target,
                                         const CalibrationTarget& target, int step_px);

/// What is left between a depth camera and the boards that a calibration has placed.
struct DepthCheck {
  DepthBias bias;  ///< of all samples
  DepthVerdict verdict = DepthVerdict::cannot_tell;
  std::string reason;                                            ///< of `cannot_tell`
  int views = 0;                                                 ///< with samples
  double nearest_m = std::numeric_limits<double>::quiet_NaN();   ///< of the samples
  double farthest_m = std::numeric_limits<double>::quiet_NaN();  ///< of the samples
  /// Measured less true at the working distance, over pixels all over the image, row by row.
  std::vector<double> bias_m;
  double rms_m = std::numeric_limits<double>::quiet_NaN();   ///< of those
  double mean_m = std::numeric_limits<double>::quiet_NaN();  ///< of those
  /// RMS of the deviations that the spread between boards says (jackknife over views).
  double spread_m = std::numeric_limits<double>::quiet_NaN();
  /// RMS of the deviations of where the calibration has a plane at that distance.
  double fresh_m = std::numeric_limits<double>::quiet_NaN();
  /// The device's own error: root of rms^2 - spread^2 - fresh^2, 0 where that is negative; and the
  /// deviation of its square.
  double error_m = std::numeric_limits<double>::quiet_NaN();
  double error_square_sigma_m2 = std::numeric_limits<double>::quiet_NaN();
};

/// Fits the bias and judges it. The calibration's lenses and poses stand for the truth; their
/// covariance says how well. Deterministic.
/// @throws std::invalid_argument for an invalid config, a camera that does not exist, or a result
/// without covariance
DepthCheck check_depth(const std::vector<DepthView>& views, const CalibrationResult& fresh,
                       int depth_camera, const DepthCheckConfig& config = {});

}  // namespace cousin
