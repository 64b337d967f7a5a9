#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

namespace cousin {

/// A point of a CalibrationTarget as an image shows it.
struct TargetObservation {
  int id = 0;                ///< of target_points()
  Eigen::Vector2d pixel_px;  ///< pixel (0, 0) is a pixel's centre
  Eigen::Matrix2d covariance_px2 = 0.01 * Eigen::Matrix2d::Identity();  ///< predicted, of (x, y)
};

/// `half_turn_unknown`: the points are in order, but the print looks the same after half a turn (a
/// chessboard of even and even, or odd and odd, inner corners); they are numbered from the end that
/// is up in the image, and whoever compares cameras must turn them to agree.
enum class TargetStatus {
  ok,
  half_turn_unknown,
  not_seen,
  too_few_points,
  disordered,
  wrong_target
};

/// What one image shows of the target.
struct TargetView {
  int frame = 0;   ///< same number = same instant, for rigs
  int camera = 0;  ///< of the rig's calibrated cameras
  TargetStatus status = TargetStatus::not_seen;
  std::string reason;                     ///< why not ok, with the number and its limit
  std::vector<TargetObservation> points;  ///< ids unique, ascending; empty unless usable
  /// By the camera's clock, of the middle row up to a constant; NaN: unknown. Only a rolling
  /// shutter's calibration asks for it.
  double time_s = std::numeric_limits<double>::quiet_NaN();
};

/// Whether the points can be used.
inline bool is_usable(const TargetView& view) {
  return view.status == TargetStatus::ok || view.status == TargetStatus::half_turn_unknown;
}

}  // namespace cousin
