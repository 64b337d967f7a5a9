#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "sim/types/board.h"
#include "sim/types/camera.h"
#include "sim/types/image.h"

namespace cousin {

/// A board found in one view, in a frame that may be a quarter turn or more off.
struct PlacedBoard {
  const Image<Rgb8>* color = nullptr;
  Camera camera;
  Eigen::Matrix3d normalized_from_board;  ///< plane z = 0 (m) to x/z, y/z of the camera
};

/// Plain boards look the same after a quarter turn. The turns (0..3, of each view's axes,
/// counter-clockwise) of all views together that cost least: a view costs what its specimens, seen
/// from above, differ from those of all views; two that follow each other cost (angle /
/// max_turn_rad)^2, at most 1. The steepest view defines the frame. Nothing for a view for which
/// another turn costs nearly the same.
std::vector<std::optional<int>> quarter_turns(const std::vector<PlacedBoard>& views,
                                              const SeedBoard& board, double max_turn_rad);

}  // namespace cousin
