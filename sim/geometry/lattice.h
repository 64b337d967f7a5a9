#pragma once

#include <cstdint>

#include "sim/types/mesh.h"

namespace cousin {

/// Adds the triangles of a lattice of (columns + 1) x (rows + 1) vertices that stand in the mesh
/// from `first` on, row by row: two a cell, cell by cell in the same order. They face where (along
/// a row) x (from row to row) points.
void add_lattice_triangles(Mesh& mesh, std::uint32_t first, std::uint32_t columns,
                           std::uint32_t rows);

}  // namespace cousin
