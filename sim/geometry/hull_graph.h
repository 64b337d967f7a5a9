#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace cousin::geometry {

/// Private to sim/geometry: a convex hull with outward unit normals that coplanar triangles share.
struct Hull {
  std::vector<Eigen::Vector3d> vertices;  ///< relative to `origin_m`
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<Eigen::Vector3d> normals;              ///< one a triangle
  std::vector<std::array<std::uint32_t, 3>> beside;  ///< triangle across the edge (k, k + 1)
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
};
/// Empty (no triangles) for points in one plane, on one line or all the same, to 1e-12 of their
/// extent.
Hull build_hull(std::span<const Eigen::Vector3d> points_m);

}  // namespace cousin::geometry
