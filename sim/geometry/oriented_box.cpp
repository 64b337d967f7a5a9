#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sim/geometry/box_search.h"
#include "sim/geometry/measure.h"
#include "sim/geometry/point_set.h"
#include "sim/geometry/rectangle.h"

namespace cousin {
namespace {

using geometry::Flat;
using geometry::PointSet;

/// About the flat's origin, of unit extent.
PointSet points_in_flat(std::span<const Eigen::Vector3d> points_m, const Flat& flat) {
  const double scale = flat.extent_m > 0 ? 1 / flat.extent_m : 1;
  PointSet points;
  points.reserve(points_m.size());
  for (const Eigen::Vector3d& p : points_m) {
    const Eigen::Vector3d q = (p - flat.origin_m) * scale;
    points.add(q.x(), q.y(), q.z());
  }
  points.pad();
  return points;
}

/// The box along `axes`: sides sorted, axes right-handed with the first two pointing to their
/// larger coordinate's positive side, so that equal boxes have equal axes.
OrientedBox box_along(const PointSet& points, const Eigen::Matrix3d& axes, const Flat& flat) {
  struct Side {
    double size = 0, middle = 0;
    Eigen::Vector3d axis;
  };
  const double scale = flat.extent_m > 0 ? flat.extent_m : 1;
  std::array<Side, 3> sides;
  for (int k = 0; k < 3; ++k) {
    const PointSet::Extent extent = points.extent(axes.col(k));
    const bool in_flat = k < flat.dimension;
    sides[static_cast<std::size_t>(k)] = {in_flat ? extent.width() * scale : 0,
                                          0.5 * (extent.low + extent.high) * scale, axes.col(k)};
  }
  std::stable_sort(sides.begin(), sides.end(),
                   [](const Side& a, const Side& b) { return a.size > b.size; });

  OrientedBox box;
  box.centre_m = flat.origin_m;
  for (int k = 0; k < 3; ++k) {
    const Side& side = sides[static_cast<std::size_t>(k)];
    box.size_m[k] = side.size;
    box.centre_m += side.middle * side.axis;
    Eigen::Index largest = 0;
    side.axis.cwiseAbs().maxCoeff(&largest);
    box.axes.col(k) = side.axis[largest] < 0 ? Eigen::Vector3d(-side.axis) : side.axis;
  }
  if (box.axes.determinant() < 0) box.axes.col(2) *= -1;
  return box;
}

/// Axes of least area within the plane of flat points; their normal last.
Eigen::Matrix3d axes_in_plane(const PointSet& points, const Eigen::Matrix3d& plane) {
  std::vector<Eigen::Vector2d> flat;
  flat.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    flat.emplace_back(plane.col(0).dot(points[i]), plane.col(1).dot(points[i]));
  }
  const Eigen::Vector2d side = geometry::smallest_rectangle_side(std::move(flat));
  Eigen::Matrix3d axes = plane;
  axes.col(0) = side.x() * plane.col(0) + side.y() * plane.col(1);
  axes.col(1) = plane.col(2).cross(axes.col(0));
  return axes;
}

/// Eigenvectors of the covariance, largest variance first, right-handed.
Eigen::Matrix3d principal_axes(const PointSet& points) {
  const double count = static_cast<double>(points.size());
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) mean += points[i] / count;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    covariance += (points[i] - mean) * (points[i] - mean).transpose() / count;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  Eigen::Matrix3d axes = solver.eigenvectors().rowwise().reverse();
  if (axes.determinant() < 0) axes.col(2) *= -1;
  return axes;
}

template <class Search>
OrientedBox smallest_box(std::span<const Eigen::Vector3d> points_m, const Search& search) {
  geometry::check_points(points_m);
  const Flat flat = geometry::find_flat(points_m);
  const PointSet points = points_in_flat(points_m, flat);
  if (flat.dimension < 2) return box_along(points, flat.axes, flat);
  if (flat.dimension == 2) return box_along(points, axes_in_plane(points, flat.axes), flat);
  return box_along(points, search(points), flat);
}

}  // namespace

OrientedBox minimum_volume_box(std::span<const Eigen::Vector3d> points_m) {
  return smallest_box(points_m, [](const PointSet& points) {
    return geometry::search_box_axes(points, principal_axes(points));
  });
}

OrientedBox minimum_volume_box(std::span<const Eigen::Vector3d> points_m, const OrientedBox& near) {
  const Eigen::Matrix3d& axes = near.axes;
  if (!axes.allFinite() || !(axes.transpose() * axes).isIdentity(1e-6)) {
    throw std::invalid_argument(
        "minimum_volume_box: the axes of the box to start from are not orthonormal");
  }
  return smallest_box(
      points_m, [&](const PointSet& points) { return geometry::refine_box_axes(points, axes); });
}

std::vector<OrientedBox> rival_boxes(std::span<const Eigen::Vector3d> points_m,
                                     const OrientedBox& least) {
  constexpr int kStep_deg = 15;
  const double apart = std::cos(10 * std::numbers::pi / 180);
  const Mesh hull = convex_hull(points_m);
  const std::span<const Eigen::Vector3d> outer =
      hull.vertices_m.empty() ? points_m : std::span<const Eigen::Vector3d>(hull.vertices_m);
  std::vector<OrientedBox> found = {least};
  for (int axis = 0; axis < 3; ++axis) {
    for (int degree = kStep_deg; degree < 90; degree += kStep_deg) {
      OrientedBox start = least;
      start.axes = least.axes *
                   Eigen::AngleAxisd(degree * std::numbers::pi / 180, Eigen::Vector3d::Unit(axis))
                       .toRotationMatrix();
      found.push_back(minimum_volume_box(outer, start));
    }
  }
  // `least` stays first, whatever a search finds a hair below it.
  std::stable_sort(found.begin() + 1, found.end(), [](const OrientedBox& a, const OrientedBox& b) {
    return a.size_m.prod() < b.size_m.prod();
  });
  std::vector<OrientedBox> kept;
  for (const OrientedBox& box : found) {
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const OrientedBox& k) {
      const Eigen::Matrix3d dots = (k.axes.transpose() * box.axes).cwiseAbs();
      return dots.rowwise().maxCoeff().minCoeff() > apart;
    });
    if (!known) kept.push_back(box);
  }
  return kept;
}

OrientedBox pca_box(std::span<const Eigen::Vector3d> points_m) {
  geometry::check_points(points_m);
  const Flat flat = geometry::find_flat(points_m);
  const PointSet points = points_in_flat(points_m, flat);
  // In a flat the covariance is singular and its null directions arbitrary: order them by the
  // flat's own axes.
  if (flat.dimension < 2) return box_along(points, flat.axes, flat);
  return box_along(points, principal_axes(points), flat);
}

}  // namespace cousin
