#pragma once

#include <string>
#include <vector>

#include "calibration/boards/grid_growth.h"
#include "calibration/boards/target_grid.h"
#include "calibration/boards/target_view.h"

namespace cousin {

/// A lattice of corners put in a chessboard's order.
struct ChessboardPlacement {
  TargetStatus status = TargetStatus::not_seen;
  std::string reason;
  FoundPixels found;
  bool inverted = false;  ///< the squares' colours are the design's swapped
};

/// The turns that make the lattice the board's, by its numbers of corners and its colours; of two
/// the one whose upper end is up in the image. A lattice of the board's size may lack corners; one
/// that is smaller says not which part it is, and one that is larger is another board.
ChessboardPlacement place_chessboard(const TargetGrid& grid,
                                     const std::vector<LatticeCorner>& lattice, int width_px,
                                     int height_px);

}  // namespace cousin
