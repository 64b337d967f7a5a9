#include "sim/geometry/cube_sphere.h"

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>
#include <string>

namespace cousin {

Mesh cube_sphere(int grid) {
  if (grid < 1)
    throw std::invalid_argument("cube_sphere: grid is " + std::to_string(grid) +
                                "; it must be at least 1");
  Mesh mesh;
  std::map<std::array<int, 3>, std::uint32_t> index_of;  // by lattice point on the cube's surface
  const auto vertex = [&](const std::array<int, 3>& lattice) {
    const auto [found, is_new] =
        index_of.try_emplace(lattice, static_cast<std::uint32_t>(mesh.vertices_m.size()));
    if (is_new) {
      Eigen::Vector3d p;
      for (int i = 0; i < 3; ++i) {
        p[i] = std::tan(std::numbers::pi / 4 *
                        (2.0 * lattice[static_cast<std::size_t>(i)] / grid - 1));
      }
      mesh.vertices_m.push_back(p.normalized());
    }
    return found->second;
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t u = (axis + 1) % 3;
    const std::size_t v = (axis + 2) % 3;
    for (const int side : {0, grid}) {
      for (int i = 0; i < grid; ++i) {
        for (int j = 0; j < grid; ++j) {
          const auto at = [&](int a, int b) {
            std::array<int, 3> lattice{};
            lattice[axis] = side;
            lattice[u] = a;
            lattice[v] = b;
            return vertex(lattice);
          };
          std::array<std::uint32_t, 4> quad = {at(i, j), at(i + 1, j), at(i + 1, j + 1),
                                               at(i, j + 1)};
          if (side == 0) std::swap(quad[1], quad[3]);
          // The shorter diagonal alternates by quadrant, so that the mesh has the cube's symmetry.
          if ((2 * i < grid) == (2 * j < grid)) {
            mesh.triangles.push_back({quad[0], quad[1], quad[2]});
            mesh.triangles.push_back({quad[0], quad[2], quad[3]});
          } else {
            mesh.triangles.push_back({quad[0], quad[1], quad[3]});
            mesh.triangles.push_back({quad[1], quad[2], quad[3]});
          }
        }
      }
    }
  }
  return mesh;
}

}  // namespace cousin
