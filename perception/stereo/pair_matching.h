#pragma once

#include <string>
#include <vector>

#include "perception/stereo/disparity_refinement.h"
#include "perception/stereo/row_alignment.h"
#include "perception/stereo/stereo_pair.h"

namespace cousin {

/// `ours`: census and semi-global matching, refined by least squares; `opencv`: cv::StereoSGBM.
enum class PairMatcher { ours, opencv };

/// From a rectified pair to disparities.
struct PairMatchConfig {
  PairMatcher matcher = PairMatcher::ours;
  int range_px = 0;  ///< largest disparity; 0: the images say so at a smaller scale
  /// Of brightness codes 0..255. Its range and shift are those that are found.
  StereoMatchConfig match = {
      .margin = 2.5, .p1 = 0.15, .p2 = 0.6, .worst_cost = 0.6, .uniqueness = 0.05};
  bool align_rows = true;  ///< the images themselves say where the right one's rows are off
  /// What has no disparity is looked for in images of half the size, so many times over.
  int smaller_sizes = 2;
  int speckle_px = 30;         ///< smaller patches of pixels are mistakes
  double least_matched = 0.1;  ///< of the pixels with texture; else the frame is not solved
  DisparityRefinementConfig refine;
};

/// What became of one pair.
struct PairFindings {
  std::string why_none;  ///< empty: there are disparities
  double textured = 0;   ///< share of the left image's pixels about which there is texture
  double matched = 0;    ///< share of these that have a disparity
  double first_px = 0;   ///< disparities that were looked for
  double last_px = 0;
  int scale = 1;   ///< the images were matched at 1 / scale, and refined at full size
  RowOffset rows;  ///< taken out of the right image
  RowOffsetSize rows_off;
  std::vector<std::string> doubts;  ///< sentences for whoever took the pair
};

struct PairDisparities {
  Image<float> disparity_px;  ///< of the rectified left image's pixels; NaN = none
  Image<float> sigma_px;      ///< standard deviation of the match; empty where none is known
  PairFindings findings;
};

/// Finds where the right image shows what the left one does: the rows' offset and the range of
/// disparities at small scales, semi-global matching of census codes with a left-right check, small
/// patches and what a nearer surface must hide left out, then least squares on the brightness. What
/// finds no likeness stays without a disparity. `pair`'s right image has its rows moved afterwards.
/// The same bytes on any number of threads.
PairDisparities match_pair(RectifiedPair& pair, const PairMatchConfig& config = {});

}  // namespace cousin
