#pragma once

#include <vector>

#include "calibration/boards/board_template.h"

namespace cousin {

/// Of lens and pixel response, where nothing is known yet.
inline constexpr double kStartBlurPx = 0.6;

/// Correlation of the image with the print over the plate, -1..1; -1 where too little is seen.
double correlation(const Image<float>& linear, const BoardPattern& pattern, const BoardTemplate& t);

/// How clearly the image prefers one print over another: its correlation with their difference.
/// About 0.8 with all markers in view, a quarter of that with one, zero where the difference is
/// hidden.
double preference(const Image<float>& linear, const BoardPattern& pattern, const BoardTemplate& a,
                  const BoardTemplate& b);

/// A placement of the print in the image and how well it is seen there.
struct PrintMatch {
  Eigen::Matrix3d normalized_from_board = Eigen::Matrix3d::Identity();
  double score = -1;  ///< correlation
  BoardTemplate print;
};
PrintMatch match_print(const Image<float>& linear, const BoardPattern& pattern, LensMap& lens,
                       const SeedBoard& board, const Eigen::Matrix3d& normalized_from_board,
                       double blur_px);

/// Moves the whole print onto the image: Gauss-Newton on the homography, offset and contrast, on
/// images blurred by 2, 1 and 0 px in turn, with Tukey's weights against what lies on the board.
/// Right to about half a square at the start: from there markers and margins lead, then squares.
/// @return the homography reached, or `start` where the print does not appear in the image
Eigen::Matrix3d aligned_print(const Image<float>& linear, const BoardPattern& pattern,
                              LensMap& lens, const SeedBoard& board, const Eigen::Matrix3d& start);

/// The best of several starts, moved onto the image; as it started where moving made it worse.
/// Score -1 without starts.
PrintMatch best_print(const Image<float>& linear, const BoardPattern& pattern, LensMap& lens,
                      const SeedBoard& board, const std::vector<Eigen::Matrix3d>& starts);

}  // namespace cousin
