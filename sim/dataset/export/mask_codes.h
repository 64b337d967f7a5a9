#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "sim/types/image.h"

namespace cousin {

/// A mask in a whole image as COCO's compressed run lengths: runs of 0 and 1 in turn, column by
/// column, each as a difference to the run two before, five bits a character from "0" on [the
/// format of pycocotools' rleToString].
/// @param mask  inside where not 0; its first pixel is (x, y) of the image.
/// @throws std::invalid_argument if it does not lie inside the image.
std::string coco_run_lengths(const Image<std::uint8_t>& mask, int x, int y, int width_px,
                             int height_px);

/// A closed line along the edges of pixels, counted from the image's corner: the first pixel's
/// corners are (0, 0) and (1, 1).
using PixelOutline = std::vector<Eigen::Vector2i>;

/// Outlines that fill exactly the mask's pixels: one for each part whose pixels share edges. A hole
/// is joined to its part by a cut of no width. Corners alone, the mask on the right hand (clockwise
/// in the image).
std::vector<PixelOutline> outlines_of(const Image<std::uint8_t>& mask, int x, int y);

/// All of them as one closed line, joined by cuts of no width, for formats that allow one.
PixelOutline joined(const std::vector<PixelOutline>& outlines);

}  // namespace cousin
