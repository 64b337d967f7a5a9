#pragma once

#include <Eigen/Core>
#include <array>

#include "calibration/solve/calibrate.h"
#include "calibration/solve/lens_value.h"

namespace cousin {

using Vector6d = Eigen::Matrix<double, 6, 1>;

/// A pose as six numbers, rotation vector (rad) and translation, and back.
Vector6d pose_vector(const Pose& pose);
Pose pose_of_vector(const Vector6d& vector);

/// A pose with what its derivative needs, made once for many points.
struct PosedFrame {
  explicit PosedFrame(const double* pose_vector);
  Eigen::Matrix3d rotation;
  Eigen::Vector3d translation;
  Eigen::Matrix3d left_jacobian;  ///< of the rotation group: exp(v + dv) = exp(J dv) exp(v)
};

/// The one cost of calibration and bundle adjustment: pixel of a point X seen by a camera of a rig,
///   q = lens(camera_from_rig (rig_from_points X)),
/// with derivatives by each. A calibration takes X from the target, a bundle adjustment solves for
/// it with `d_point`; a single camera has no `camera_from_rig`.
struct ObservationValue {
  Eigen::Vector2d pixel_px;
  Eigen::Matrix<double, 2, 6, Eigen::RowMajor> d_rig_from_points, d_camera_from_rig;
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> d_point;
};
/// @param camera_from_rig  null: the identity, and its derivative is left as it is
/// @param d_lens  2 x lens_parameter_count, row by row, or null: no derivatives at all
/// @return false where the point has no pixel
bool observe(const LensShape& shape, const double* lens, const PosedFrame* camera_from_rig,
             const PosedFrame& rig_from_points, const Eigen::Vector3d& point,
             ObservationValue& value, double* d_lens);

/// `observe` of a single camera whose focal lengths are `zoom` times the lens's: the pixel moves
/// from the principal point by that factor, whatever the lens model.
/// @param d_lens  as of `observe`
/// @param d_zoom  of the pixel; may be null
bool observe_zoomed(const LensShape& shape, const double* lens, double zoom, const PosedFrame& pose,
                    const Eigen::Vector3d& point, ObservationValue& value, double* d_lens,
                    Eigen::Vector2d* d_zoom);

/// Squared residual s = |r|^2 under a loss rho(s), as r' = g r with |r'|^2 = rho(s); `d` takes dr
/// to dr'. `weight` is rho'(s).
struct Softened {
  double factor = 1;
  double weight = 1;
  Eigen::Matrix2d d = Eigen::Matrix2d::Identity();
};
Softened soften(RobustLoss loss, double turn, const Eigen::Vector2d& residual);

}  // namespace cousin
