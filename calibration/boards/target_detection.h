#pragma once

#include <cstdint>

#include "calibration/boards/charuco_layout.h"
#include "calibration/boards/target_view.h"
#include "sim/config/fields.h"
#include "sim/types/calibration_target.h"
#include "sim/types/image.h"

namespace cousin {

struct TargetDetectionConfig {
  int half_window_px = 5;      ///< of a corner's window, if the print about it is wide enough
  double least_share = 0;      ///< of the target's points; fewer are too few; at least 6 points
  double max_stray = 0.25;     ///< of a step: points farther from where their neighbours have them
  double max_misplaced = 0.1;  ///< of a step: and measured ones, from their neighbours' homography
  double max_noise = 0.15;     ///< of the contrast: what a corner's fit may leave
  double max_sigma_px = 0.5;   ///< points predicted worse than this are dropped
  double floor_px = 0.002;     ///< deviation that is added for what the model leaves out
};
Fields fields(TargetDetectionConfig& config);
void validate(const TargetDetectionConfig& config);

/// Light of an 8-bit sRGB picture by Rec. 709's weights, 0..1; and of a grey one that is linear.
Image<float> light_of(const Image<Rgb8>& color);
Image<float> light_of(const Image<std::uint8_t>& linear_grey);

/// Pairs of neighbouring markers that lie as on the charuco board in either layout.
struct LayoutVotes {
  int current = 0, legacy = 0;
};
/// @throws as find_target.
LayoutVotes layout_votes(const Image<float>& light, const CalibrationTarget& target);

/// Finds a target of any kind and measures its points (the seed board by seed_board_target.h):
/// 1. chessboard: saddles grow into a lattice, whose size and colours say which corner is which;
///    charuco and april grid: cv::aruco's markers predict the corners; circles: OpenCV's grids.
/// 2. what neighbours predict and is not found yet is looked for among the saddles, outward;
/// 3. points that do not lie among their neighbours go, and a target that is mirrored, disordered
/// or
///    of another size is refused, with the reason;
/// 4. corners by fit_saddle in a window that holds nothing of the print but the corner's squares;
///    discs by fit_disc, moved from the ellipse's centre to the disc's by the homography of all.
/// The covariance is each fit's own, scaled by the noise it leaves pooled with the view's median.
/// Parts of a charuco board, an april grid and a seed board are views; of a chessboard, its whole
/// lattice must be spanned; a part of circles is one where its outline tells which part it is.
/// @param light  linear, black to white anywhere in it; 65535 a side at most
/// @param layout  of a charuco board
/// @throws std::invalid_argument for an invalid target or config, an unknown dictionary.
TargetView find_target(const Image<float>& light, const CalibrationTarget& target,
                       const TargetDetectionConfig& config = {},
                       CharucoLayout layout = CharucoLayout::current);

}  // namespace cousin
