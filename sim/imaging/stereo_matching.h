#pragma once

#include <cstdint>

#include "sim/types/image.h"

namespace cousin {

/// How a disparity between whole pixels follows from the costs about the best one.
enum class SubPixelFit {
  parabola,     ///< of three costs
  equiangular,  ///< two lines of opposite slope: costs that grow linearly, as Hamming distances do
                ///< [Shimizu & Okutomi, IJCV 2005]
};

/// Semi-global matching of census codes [Hirschmueller, TPAMI 2008]. Costs are Hamming distances
/// summed over a block.
struct StereoMatchConfig {
  int census_width_px = 7;
  int census_height_px = 7;
  double margin = 0;   ///< differences of brightness below are none, in the image's numbers
  int block_px = 5;    ///< odd; side of the block that costs are summed over
  int shift_px = 0;    ///< disparities of shift .. shift + range are found
  int range_px = 126;  ///< 1..254
  int paths = 8;       ///< 4 or 8
  double p1 = 0.04, p2 = 0.25;  ///< penalties over the largest cost of a block
  double worst_cost = 0.4;      ///< over what two windows without anything in common would cost
  double uniqueness = 0.15;     ///< least `confidence`; 0 = not checked
  double left_right_px = 1;     ///< largest disagreement with the right image's match; < 0 = none
  double texture = 0.02;        ///< least share of a block's pairs that differ by the margin
  SubPixelFit fit = SubPixelFit::equiangular;
};
/// @throws std::invalid_argument naming field, value and limit.
void validate(const StereoMatchConfig& config);

/// Why a pixel has no disparity, in the order in which it is asked.
enum class MatchReason : std::uint8_t {
  none,          ///< it has one
  no_texture,    ///< too few pairs of pixels differ
  out_of_range,  ///< the best candidate is the first or the last
  unlike,        ///< not even the best candidate is alike
  ambiguous,     ///< another candidate is nearly as good
  left_right,    ///< the right image's pixel matches something else
};

struct StereoMatches {
  Image<float> disparity_px;  ///< x_left - x_right of the left image's pixels; NaN = none
  Image<float> confidence;    ///< 1 - block's cost over the least elsewhere, in [0, 1]
  Image<MatchReason> reason;
};

/// Disparities of a rectified pair: the same point lies in the same row of both images, in the
/// right one `disparity` further to the left. Work grows with width * height * range; the result
/// does not depend on the number of threads.
/// @throws std::invalid_argument for an invalid configuration, or images of different or no size.
StereoMatches match_stereo(const Image<float>& left, const Image<float>& right,
                           const StereoMatchConfig& config = {});
StereoMatches match_stereo(const Image<std::uint16_t>& left, const Image<std::uint16_t>& right,
                           const StereoMatchConfig& config = {});

}  // namespace cousin
