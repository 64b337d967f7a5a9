#pragma once

#include <Eigen/Core>
#include <vector>

namespace cousin {

/// A point of a plane and where it is seen on the plane z = 1 of a camera (undistorted).
struct PlanePoint {
  Eigen::Vector2d in_plane;
  Eigen::Vector2d normalized;
  double sigma = 1;  ///< of `normalized`, per axis
};

struct HomographyFit {
  bool ok = false;  ///< false: fewer than four points, or all but few on a line
  Eigen::Matrix3d normalized_from_plane = Eigen::Matrix3d::Identity();
  std::vector<double> residual;  ///< distance of each point from its prediction, over its sigma
};

/// Homography by the normalised linear method [Hartley, TPAMI 1997], then Gauss-Newton on the
/// distances with Huber weights at `huber` sigmas. The scale is such that the third coordinate is
/// positive at the points.
HomographyFit fit_homography(const std::vector<PlanePoint>& points, double huber = 2.5);

/// The image of a plane point.
Eigen::Vector2d transfer(const Eigen::Matrix3d& homography, const Eigen::Vector2d& point);

}  // namespace cousin
