#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/types/camera.h"
#include "sim/types/pose.h"

namespace cousin {

/// A point of the board (z = 0) and where it was seen.
struct BoardPoint {
  Eigen::Vector3d in_board_m;
  Eigen::Vector2d pixel_px;
  Eigen::Matrix2d covariance_px2 = 0.01 * Eigen::Matrix2d::Identity();
};

/// A pose worse by less than this is not refuted: 1 in 1000 is, of two at equal odds.
inline constexpr double kAmbiguousCost = 13.8;

struct PlanarPose {
  bool ok = false;  ///< false: fewer than four points, points on a line, or no convergence
  Pose camera_from_board;
  double rms_px = 0;  ///< per coordinate, all points
  /// The other of a plane's two poses explains the points almost as well [its squared residuals,
  /// over their deviations or what they do
  /// miss by, are less than `kAmbiguousCost` more], and they differ by more than a
  /// degree: which one is true does not show.
  bool is_ambiguous = false;
};

/// W with W' W = covariance^-1, lower triangular: W times a residual has unit covariance. The
/// covariance must be positive definite.
Eigen::Matrix2d whitening(const Eigen::Matrix2d& covariance);

/// Rotation by a rotation vector, and the cross-product matrix.
Eigen::Quaterniond exp_rotation(const Eigen::Vector3d& rotation_vector);
Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v);

/// Pose of a plane through a known lens: homography, then Levenberg-Marquardt on pixels with Huber
/// weights, from the homography's pose and from its mirror about the line of sight (the second
/// minimum of nearly frontal or distant planes [Collins & Bartoli, IJCV 2014]); the better one is
/// returned.
PlanarPose estimate_planar_pose(const Camera& camera, const std::vector<BoardPoint>& points);

}  // namespace cousin
