#pragma once

#include <cstdint>
#include <string>

#include "calibration/boards/target_grid.h"
#include "calibration/boards/target_view.h"
#include "sim/types/image.h"

namespace cousin {

/// Discs put in a target's order.
struct CircleGrid {
  TargetStatus status = TargetStatus::not_seen;
  std::string reason;
  FoundPixels found;     ///< of blobs: good to a fraction of a pixel
  double radius_px = 0;  ///< of a disc, the median
};

/// All discs of a symmetric or asymmetric grid, by cv::findCirclesGrid; else a part of them, where
/// its outline tells which (partial_circles.h). A symmetric grid and an even number of staggered
/// rows look the same after half a turn: they are numbered from the end that is up in the image.
/// Staggered rows of an odd number are their own mirror image, so that a mirrored picture goes
/// unnoticed.
CircleGrid find_circle_grid(const Image<std::uint8_t>& image, const TargetGrid& grid);

}  // namespace cousin
