#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "sim/types/image.h"

namespace cousin {

/// Masks in COCO's codes: run lengths and polygons, written and read.

/// A mask in a whole image as COCO's compressed run lengths: runs of 0 and 1 in turn, column by
/// column, each as a difference to the run two before, five bits a character from "0" on [the
/// format of pycocotools' rleToString].
/// @param mask  inside where not 0; its first pixel is (x, y) of the image.
/// @throws std::invalid_argument if it does not lie inside the image.
std::string coco_run_lengths(const Image<std::uint8_t>& mask, int x, int y, int width_px,
                             int height_px);

/// The runs that such a text holds. @throws std::invalid_argument saying at which character the
/// text is none.
std::vector<std::int64_t> runs_of_coco(std::string_view text);

/// A mask in a box that holds all of it: 255 inside, 0 outside. Empty if nothing is inside.
struct PlacedMask {
  int x = 0, y = 0;  ///< of its first pixel in the image
  Image<std::uint8_t> mask;
};

/// Most pixels of the box of a mask that is read.
inline constexpr std::int64_t kMostMaskPixels = std::int64_t{1} << 26;

/// @throws std::invalid_argument, before memory is taken, if a run is negative, the runs do not
/// fill the image, or the mask's box has more than kMostMaskPixels.
PlacedMask mask_of_runs(const std::vector<std::int64_t>& runs, int width_px, int height_px);

/// The pixels of all polygons together, each filled by the even-odd rule with the very rounding of
/// pycocotools' rleFrPoly. Points count from the image's corner; what lies outside the image is cut
/// off.
/// @throws std::invalid_argument as mask_of_runs, or if the polygons are longer than 2e7 pixels.
PlacedMask mask_of_polygons(const std::vector<std::vector<Eigen::Vector2d>>& polygons, int width_px,
                            int height_px);

/// A closed line along the edges of pixels, counted from the image's corner: the first pixel's
/// corners are (0, 0) and (1, 1).
using PixelOutline = std::vector<Eigen::Vector2i>;

/// All lines between the mask and what is not mask, corners alone, the mask on their right hand:
/// those around a part are clockwise in the image, those around a hole are not.
struct PixelRing {
  PixelOutline line;
  int part = 0;  ///< pixels that share edges are one part
  bool is_hole = false;
};
/// @param most_edges  of pixels, in all @throws std::invalid_argument if there are more
std::vector<PixelRing> rings_of(const Image<std::uint8_t>& mask, int x, int y,
                                std::size_t most_edges = std::numeric_limits<std::size_t>::max());

/// Outlines that fill exactly the mask's pixels: one for each part whose pixels share edges. A hole
/// is joined to its part by a cut of no width. Corners alone, the mask on the right hand (clockwise
/// in the image).
std::vector<PixelOutline> outlines_of(const Image<std::uint8_t>& mask, int x, int y);

/// All of them as one closed line, joined by cuts of no width, for formats that allow one.
PixelOutline joined(const std::vector<PixelOutline>& outlines);

}  // namespace cousin
