#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "sim/types/mesh.h"

namespace cousin {

inline Mesh box_solid(const Eigen::Vector3d& size_m) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d corner((i & 1) - 0.5, ((i >> 1) & 1) - 0.5, ((i >> 2) & 1) - 0.5);
    mesh.vertices_m.emplace_back(corner.cwiseProduct(size_m));
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

/// Rings of latitude on an ellipsoid; `waist` pinches its middle: 0 none, towards 1 a dumbbell.
inline Mesh ellipsoid_solid(const Eigen::Vector3d& half_m, double waist = 0, int rings = 40,
                            int sides = 64) {
  Mesh mesh;
  const auto vertex = [&](double latitude, double longitude) {
    const double pinch = 1 - waist * std::exp(-std::pow(std::sin(latitude) / 0.35, 2));
    return Eigen::Vector3d(std::sin(latitude) * half_m.x(),
                           pinch * std::cos(latitude) * std::cos(longitude) * half_m.y(),
                           pinch * std::cos(latitude) * std::sin(longitude) * half_m.z());
  };
  mesh.vertices_m.push_back(vertex(-std::numbers::pi / 2, 0));
  for (int r = 1; r < rings; ++r) {
    for (int s = 0; s < sides; ++s) {
      mesh.vertices_m.push_back(vertex(std::numbers::pi * (static_cast<double>(r) / rings - 0.5),
                                       2 * std::numbers::pi * s / sides));
    }
  }
  mesh.vertices_m.push_back(vertex(std::numbers::pi / 2, 0));
  const auto last = static_cast<std::uint32_t>(mesh.vertices_m.size() - 1);
  const auto at = [&](int r, int s) {
    return static_cast<std::uint32_t>(1 + (r - 1) * sides + s % sides);
  };
  for (int s = 0; s < sides; ++s) {
    mesh.triangles.push_back({0, at(1, s + 1), at(1, s)});
    mesh.triangles.push_back({last, at(rings - 1, s), at(rings - 1, s + 1)});
    for (int r = 1; r + 1 < rings; ++r) {
      mesh.triangles.push_back({at(r, s), at(r, s + 1), at(r + 1, s + 1)});
      mesh.triangles.push_back({at(r, s), at(r + 1, s + 1), at(r + 1, s)});
    }
  }
  return mesh;
}

}  // namespace cousin
