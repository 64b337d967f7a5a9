#include "scenes/strawberries/leaf_crowd.h"

#include <cmath>

#include "sim/geometry/surface_crossing.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

constexpr double kCell_m = 0.012;

using Corners = std::array<Vector3d, 3>;

Corners corners_of(const Mesh& mesh, std::size_t t, const Vector3d& at_m) {
  const auto& triangle = mesh.triangles[t];
  return {mesh.vertices_m[triangle[0]] + at_m, mesh.vertices_m[triangle[1]] + at_m,
          mesh.vertices_m[triangle[2]] + at_m};
}

/// Calls `visit` with the key of each cell that a triangle's box touches, until it returns true.
template <class Visit>
bool any_cell(const Corners& c, const Visit& visit) {
  const auto cell = [](const Vector3d& p) -> Eigen::Vector3i {
    return (p / kCell_m).array().floor().cast<int>();
  };
  const Eigen::Vector3i low = cell(c[0].cwiseMin(c[1]).cwiseMin(c[2]));
  const Eigen::Vector3i high = cell(c[0].cwiseMax(c[1]).cwiseMax(c[2]));
  for (int z = low.z(); z <= high.z(); ++z) {
    for (int y = low.y(); y <= high.y(); ++y) {
      for (int x = low.x(); x <= high.x(); ++x) {
        const auto part = [](int i) { return static_cast<std::uint64_t>(i + (1 << 20)); };
        if (visit(part(x) | part(y) << 21 | part(z) << 42)) return true;
      }
    }
  }
  return false;
}

}  // namespace

bool LeafCrowd::is_crossed_by(const Mesh& leaflet, const Vector3d& at_m) const {
  for (std::size_t t = 0; t < leaflet.triangles.size(); ++t) {
    const Corners own = corners_of(leaflet, t, at_m);
    const Vector3d low = own[0].cwiseMin(own[1]).cwiseMin(own[2]);
    const Vector3d high = own[0].cwiseMax(own[1]).cwiseMax(own[2]);
    const bool crosses = any_cell(own, [&](std::uint64_t key) {
      const auto found = cells_.find(key);
      if (found == cells_.end()) return false;
      for (const std::uint32_t k : found->second) {
        const Corners& other = triangles_[k];
        const bool apart =
            (other[0].cwiseMin(other[1]).cwiseMin(other[2]).array() > high.array()).any() ||
            (other[0].cwiseMax(other[1]).cwiseMax(other[2]).array() < low.array()).any();
        if (!apart && triangles_meet(own, other)) return true;
      }
      return false;
    });
    if (crosses) return true;
  }
  return false;
}

void LeafCrowd::add(const Mesh& leaflet, const Vector3d& at_m) {
  for (std::size_t t = 0; t < leaflet.triangles.size(); ++t) {
    const auto index = static_cast<std::uint32_t>(triangles_.size());
    triangles_.push_back(corners_of(leaflet, t, at_m));
    any_cell(triangles_.back(), [&](std::uint64_t key) {
      cells_[key].push_back(index);
      return false;
    });
  }
}

}  // namespace cousin
