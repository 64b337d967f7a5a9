#include "sim/geometry/isosurface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <utility>

namespace cousin {
namespace {

constexpr std::size_t kMostPoints = std::size_t{1} << 28;
constexpr double kLeastShare = 1e-3;  ///< of an edge, between a vertex and a lattice point

/// Corners of a cell along its six paths from (0, 0, 0) to (1, 1, 1), an axis a step: bit k is
/// axis k. Cells share their faces' diagonals. Even paths make tetrahedra of positive volume.
struct Path {
  std::array<unsigned, 4> corner;
  bool is_even;
};
constexpr std::array<Path, 6> kPaths = {{{{0, 1, 3, 7}, true},
                                         {{0, 2, 6, 7}, true},
                                         {{0, 4, 5, 7}, true},
                                         {{0, 2, 3, 7}, false},
                                         {{0, 1, 5, 7}, false},
                                         {{0, 4, 6, 7}, false}}};

/// Makes the triangles of one lattice.
class Marcher {
 public:
  explicit Marcher(const ValueLattice& lattice) : lattice_(lattice) {}

  Mesh run() {
    for (int z = 0; z + 1 < lattice_.size[2]; ++z) {
      for (int y = 0; y + 1 < lattice_.size[1]; ++y) {
        for (int x = 0; x + 1 < lattice_.size[0]; ++x) cell(x, y, z);
      }
    }
    return std::move(mesh_);
  }

 private:
  struct Corner {
    std::array<int, 3> at;
    std::size_t index;
    double value;
    bool is_inside() const { return value < 0; }
  };

  void cell(int x, int y, int z) {
    std::array<Corner, 8> corners;
    int inside = 0;
    for (unsigned k = 0; k < 8; ++k) {
      const std::array<int, 3> at = {x + static_cast<int>(k & 1U),
                                     y + static_cast<int>(k >> 1U & 1U),
                                     z + static_cast<int>(k >> 2U)};
      const std::size_t index = lattice_.index(at[0], at[1], at[2]);
      corners[k] = {at, index, static_cast<double>(lattice_.values[index])};
      inside += corners[k].is_inside() ? 1 : 0;
    }
    if (inside == 0 || inside == 8) return;
    for (const Path& path : kPaths) {
      tetrahedron({corners[path.corner[0]], corners[path.corner[1]], corners[path.corner[2]],
                   corners[path.corner[3]]},
                  path.is_even);
    }
  }

  /// @param positive  whether the corners, in order, span a positive volume
  void tetrahedron(std::array<Corner, 4> c, bool positive) {
    // Inside corners first; each exchange turns the order's sense.
    int inside = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      if (!c[i].is_inside()) continue;
      for (std::size_t k = i; k > static_cast<std::size_t>(inside); --k) {
        std::swap(c[k], c[k - 1]);
        positive = !positive;
      }
      ++inside;
    }
    if (inside == 0 || inside == 4) return;
    if (inside == 1) {
      triangle(vertex(c[0], c[1]), vertex(c[0], c[2]), vertex(c[0], c[3]), positive);
    } else if (inside == 3) {
      triangle(vertex(c[3], c[0]), vertex(c[3], c[1]), vertex(c[3], c[2]), positive);
    } else {
      const std::uint32_t ac = vertex(c[0], c[2]), ad = vertex(c[0], c[3]);
      const std::uint32_t bc = vertex(c[1], c[2]), bd = vertex(c[1], c[3]);
      triangle(ac, ad, bd, positive);
      triangle(ac, bd, bc, positive);
    }
  }

  void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c, bool forward) {
    if (!forward) std::swap(b, c);
    mesh_.triangles.push_back({a, b, c});
  }

  /// The vertex on the edge between two corners, made once.
  std::uint32_t vertex(const Corner& a, const Corner& b) {
    const Corner& low = a.index < b.index ? a : b;
    const Corner& high = a.index < b.index ? b : a;
    std::uint64_t direction = 0;
    for (std::size_t k = 0; k < 3; ++k)
      direction |= static_cast<std::uint64_t>(high.at[k] != low.at[k]) << k;
    const auto [found, is_new] = vertices_.try_emplace(
        low.index * 8 + direction, static_cast<std::uint32_t>(mesh_.vertices_m.size()));
    if (is_new) {
      const double share =
          std::clamp(low.value / (low.value - high.value), kLeastShare, 1 - kLeastShare);
      const Eigen::Vector3d from = lattice_.point_m(low.at[0], low.at[1], low.at[2]);
      const Eigen::Vector3d to = lattice_.point_m(high.at[0], high.at[1], high.at[2]);
      mesh_.vertices_m.push_back(from + share * (to - from));
    }
    return found->second;
  }

  const ValueLattice& lattice_;
  Mesh mesh_;
  std::unordered_map<std::uint64_t, std::uint32_t> vertices_;  ///< by edge
};

void check(const ValueLattice& lattice) {
  std::size_t count = 1;
  for (const int size : lattice.size) {
    if (size < 0) throw std::invalid_argument("isosurface: a side of the lattice is negative");
    count *= std::min(static_cast<std::size_t>(size), kMostPoints);
    if (count > kMostPoints)
      throw std::invalid_argument("isosurface: the lattice has more than 2^28 points");
  }
  if (count != lattice.values.size()) {
    throw std::invalid_argument("isosurface: " + std::to_string(lattice.values.size()) +
                                " values for " + std::to_string(count) + " points");
  }
  if (!(lattice.step_m > 0) || !std::isfinite(lattice.step_m) || !lattice.low_m.allFinite())
    throw std::invalid_argument("isosurface: the lattice's step or corner is not valid");
  if (!std::all_of(lattice.values.begin(), lattice.values.end(),
                   [](float v) { return std::isfinite(v); }))
    throw std::invalid_argument("isosurface: a value is not finite");
}

}  // namespace

Mesh isosurface(const ValueLattice& lattice) {
  check(lattice);
  return Marcher(lattice).run();
}

Mesh large_parts(const Mesh& mesh, double least_share) {
  // Vertices that share a triangle share a root.
  std::vector<std::uint32_t> parent(mesh.vertices_m.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const auto& t : mesh.triangles) {
    for (const std::uint32_t v : t) {
      const std::uint32_t a = root(t[0]), b = root(v);
      parent[std::max(a, b)] = std::min(a, b);
    }
  }
  std::vector<double> area_m2(mesh.vertices_m.size(), 0);
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d& a = mesh.vertices_m[t[0]];
    area_m2[root(t[0])] +=
        0.5 * (mesh.vertices_m[t[1]] - a).cross(mesh.vertices_m[t[2]] - a).norm();
  }
  const double largest_m2 = area_m2.empty() ? 0 : *std::max_element(area_m2.begin(), area_m2.end());
  constexpr std::uint32_t kDropped = 0xffffffff;
  std::vector<std::uint32_t> kept(mesh.vertices_m.size(), kDropped);
  Mesh result;
  for (const auto& t : mesh.triangles) {
    if (area_m2[root(t[0])] < least_share * largest_m2) continue;
    std::array<std::uint32_t, 3> renumbered{};
    for (std::size_t k = 0; k < 3; ++k) {
      std::uint32_t& place = kept[t[k]];
      if (place == kDropped) {
        place = static_cast<std::uint32_t>(result.vertices_m.size());
        result.vertices_m.push_back(mesh.vertices_m[t[k]]);
      }
      renumbered[k] = place;
    }
    result.triangles.push_back(renumbered);
  }
  return result;
}

}  // namespace cousin
