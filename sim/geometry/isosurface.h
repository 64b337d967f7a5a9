#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "sim/types/mesh.h"

namespace cousin {

/// Values at the points of a box-shaped lattice, x fastest.
struct ValueLattice {
  Eigen::Vector3d low_m = Eigen::Vector3d::Zero();  ///< of the first point
  double step_m = 1;
  std::array<int, 3> size{};  ///< points along x, y, z
  std::vector<float> values;  ///< size[0] * size[1] * size[2]; below zero = inside

  std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(size[1]) +
            static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(size[0]) +
           static_cast<std::size_t>(x);
  }
  Eigen::Vector3d point_m(int x, int y, int z) const {
    return low_m + step_m * Eigen::Vector3d(x, y, z);
  }
};

/// The surface where the values pass through zero, outward triangles: marching tetrahedra [Doi &
/// Koide, IEICE Trans. 74(1), 1991] on six tetrahedra a cell. Every edge has exactly two triangles
/// but where inside points touch the lattice's border: there the surface is open. Vertices are at
/// least a thousandth of an edge away from lattice points, so that no triangle vanishes.
/// @throws std::invalid_argument if sizes and values disagree, a value is not finite, step_m is not
/// positive, or there are more than 2^28 points.
Mesh isosurface(const ValueLattice& lattice);

/// The mesh without its small parts: those whose area is below `least_share` of the largest one's.
/// Vertices that no triangle uses are dropped.
Mesh large_parts(const Mesh& mesh, double least_share);

}  // namespace cousin
