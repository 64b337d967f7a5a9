#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "sim/types/calibration_target.h"

namespace cousin {

/// A print cut into cells of one colour: every edge between ink and paper is an edge of cells, so
/// that it is as sharp as geometry is. A lattice of vertices over the whole plate; where discs are,
/// it is bent so that their outlines are polygons of edges with the disc's area.
struct PrintGrid {
  int columns = 0, rows = 0;          ///< of cells
  std::vector<Eigen::Vector2d> at_m;  ///< (columns + 1) x (rows + 1), row by row from the lowest
  std::vector<std::uint8_t> has_ink;  ///< one a cell, row by row from the lowest

  std::size_t vertex(int column, int row) const {
    return static_cast<std::size_t>(row * (columns + 1) + column);
  }
};

/// @param margin_m  white between the print and the plate's edges
/// @param detail_m  longest edge of a cell
/// @throws std::invalid_argument if the target is not valid, its dictionary has too few markers, or
/// the grid would have more than 4 million cells.
PrintGrid print_grid(const CalibrationTarget& target, double margin_m, double detail_m);

}  // namespace cousin
