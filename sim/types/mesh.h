#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace cousin {

/// Triangle mesh. Triangles are counter-clockwise seen from outside. No uniqueness or
/// watertightness is implied: see check_watertight() in sim/geometry/measure.h.
struct Mesh {
  std::vector<Eigen::Vector3d> vertices_m;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

}  // namespace cousin
