#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "calibration/boards/target_grid.h"
#include "calibration/boards/target_view.h"
#include "sim/types/image.h"

namespace cousin {

/// Whether a target looks the same after half a turn about its middle: its points, not its marks.
bool is_half_turn_symmetric(const TargetGrid& grid);

/// A part of a grid of discs put in the grid's order.
struct PartialCircles {
  TargetStatus status = TargetStatus::not_seen;
  std::string reason;
  FoundPixels found;  ///< as far as the discs given are exact
  int discs = 0;      ///< of the lattice that grew
};

/// Places a part of a symmetric or asymmetric grid, whose discs all look alike, by its outline. A
/// lattice grows over the discs; beside each of its discs a place is a disc's, or bright paper, or
/// unknown (dark, or outside the picture). The part is then tried everywhere on the grid, in every
/// way a lattice can be counted: each disc must fall on one of the grid's, no paper may. One way
/// (or two that half a turn makes of each other) is an answer; several are `too_few_points` with
/// their number; none is `wrong_target`.
/// @param tone  the picture, dark discs on bright paper
/// @param discs_px  centres of dark blobs, at most 5000 of them are looked at
PartialCircles place_partial_circles(const Image<std::uint8_t>& tone,
                                     const std::vector<Eigen::Vector2d>& discs_px,
                                     const TargetGrid& grid);

}  // namespace cousin
