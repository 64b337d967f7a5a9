#pragma once

#include <Eigen/Core>
#include <span>

#include "sim/types/mesh.h"

namespace cousin {

/// The affine frame of a star-shaped surface: x(u) = centre + axes * u * r(u) for unit u. With r =
/// 1 it is an ellipsoid.
struct SurfaceFrame {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes_m = Eigen::Matrix3d::Identity();  ///< columns: semi-axes

  Eigen::Vector3d point_m(const Eigen::Vector3d& u, double radius) const {
    return centre_m + axes_m * (u * radius);
  }
};

/// An ellipsoid about points of an object's upper side that lies on z = 0: the points are mirrored
/// through the middle of their box from the board up, so that the unseen lower half is as wide.
/// @throws std::invalid_argument below 4 points.
SurfaceFrame frame_of_points(std::span<const Eigen::Vector3d> points_m);

/// The ellipsoid with the volume, centroid and second moments of a closed mesh.
SurfaceFrame frame_of_solid(const Mesh& mesh);

}  // namespace cousin
