#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace cousin::geometry {

/// Triangles of one polygon, or why there are none.
struct PolygonTriangles {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::string problem;  ///< empty = all is well
};

/// Corners of a polygon that is not cut by a fan; more are refused, as the time grows with their
/// square.
inline constexpr std::size_t kMostPolygonCorners = 4096;

/// Cuts a polygon into corners - 2 triangles that face as it does and cover it once, seen along its
/// normal (Newell's, which exists for a polygon that is not flat, too). The fan from its first
/// corner is taken where it does that, as in every convex polygon; else ears are cut off [Meisters
/// 1975; Eberly 2002]. An outline that reaches a hole over a bridge edge is one polygon.
/// @param corners  at least 3 indices into `vertices`, in the order of the outline
/// Problems: the outline crosses itself; more than kMostPolygonCorners.
PolygonTriangles triangles_of_polygon(std::span<const Eigen::Vector3d> vertices,
                                      std::span<const std::uint32_t> corners);

}  // namespace cousin::geometry
