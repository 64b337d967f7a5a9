#pragma once

#include <cstdint>

#include "sim/types/capture.h"
#include "sim/types/image.h"
#include "sim/types/seams.h"

namespace cousin {

/// The capture with photographs and lenses smaller by the least whole number that makes the longer
/// side of each at most `largest_side_px`: pixels are means of the squares they cover, last rows
/// and columns that fill none are left out. Other images than colour are dropped.
Capture reduced(const Capture& capture, int largest_side_px);
/// The camera of such a photograph. @param by  >= 1
Camera reduced(const Camera& camera, int by);

/// Cameras of the size of the full photographs, as somebody's poses have them, become those of
/// reduced(full, largest_side_px); others stay.
Poses reduced(Poses poses, const Capture& full, int largest_side_px);

/// A mask as such a photograph needs it: a pixel is 255 where none that it covers is 0.
/// @throws std::invalid_argument unless it is of the small photograph's size or by a whole number
/// larger, as `reduced` makes it small
Image<std::uint8_t> reduced_mask(const Image<std::uint8_t>& mask, int width_px, int height_px);

}  // namespace cousin
