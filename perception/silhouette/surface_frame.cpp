#include "perception/silhouette/surface_frame.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace cousin {
namespace {

/// Semi-axes are at least this: a cluster may be flat or a line.
constexpr double kLeastAxis_m = 1e-4;

/// Principal directions, right-handed: a mirrored frame would turn the surface inside out.
Eigen::Matrix3d axes_of(const Eigen::Matrix3d& covariance) {
  Eigen::Matrix3d axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvectors();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  return axes;
}

double quantile(std::vector<double> values, double share) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

SurfaceFrame frame_of_points(std::span<const Eigen::Vector3d> points_m) {
  if (points_m.size() < 4) {
    throw std::invalid_argument("a frame needs 4 points or more; there are " +
                                std::to_string(points_m.size()));
  }
  // Middle of the box from the board up; the 2 % farthest points on each side do not count.
  Eigen::Vector3d middle;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const Eigen::Vector3d& point : points_m) values.push_back(point[axis]);
    const double low = axis == 2 ? 0 : quantile(values, 0.02);
    middle[axis] = 0.5 * (low + quantile(values, 0.98));
  }

  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& point : points_m)
    covariance += (point - middle) * (point - middle).transpose();
  const Eigen::Matrix3d rotation = axes_of(covariance);
  Eigen::Vector3d semi_axes;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> extents;
    for (const Eigen::Vector3d& point : points_m)
      extents.push_back(std::abs(rotation.col(axis).dot(point - middle)));
    semi_axes[axis] = std::max(kLeastAxis_m, quantile(extents, 0.98));
  }
  return {middle, rotation * semi_axes.asDiagonal()};
}

SurfaceFrame frame_of_solid(const Mesh& mesh) {
  // Signed tetrahedra from a vertex of the mesh; moments of a tetrahedron with a corner at the
  // origin.
  const Eigen::Vector3d origin = mesh.vertices_m.at(0);
  double volume = 0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (const auto& [i, j, k] : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices_m[i] - origin, b = mesh.vertices_m[j] - origin,
                          c = mesh.vertices_m[k] - origin;
    const double v = a.dot(b.cross(c)) / 6;
    const Eigen::Vector3d sum = a + b + c;
    volume += v;
    first += v / 4 * sum;
    second += v / 20 *
              (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  const Eigen::Vector3d centroid = first / volume;
  const Eigen::Matrix3d covariance = second / volume - centroid * centroid.transpose();
  const Eigen::Matrix3d rotation = axes_of(covariance);
  // A solid ellipsoid's variance along a semi-axis a is a^2 / 5.
  Eigen::Vector3d semi_axes;
  for (int axis = 0; axis < 3; ++axis) {
    const double variance = rotation.col(axis).dot(covariance * rotation.col(axis));
    semi_axes[axis] = std::max(kLeastAxis_m, std::sqrt(std::max(0.0, 5 * variance)));
  }
  return {origin + centroid, rotation * semi_axes.asDiagonal()};
}

}  // namespace cousin
