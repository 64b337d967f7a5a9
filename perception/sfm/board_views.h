#pragma once

#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "calibration/bundle/bundle_adjustment.h"
#include "perception/sfm/sfm_model.h"
#include "sim/types/board.h"
#include "sim/types/seams.h"

namespace cousin {

/// What one image's corners say of its place, by themselves.
struct BoardViewConfig {
  int min_corners = 8;    ///< fewer say nothing
  double max_rms_px = 2;  ///< nor do corners that fit worse, per coordinate
};

/// Pose of the camera in the board's frame from one image's corners through a known lens; none
/// where they say nothing.
std::optional<Pose> camera_from_board(const Camera& lens, const FrameCorners& corners,
                                      const SeedBoard& board, const BoardViewConfig& config = {});

/// How a model's poses stand to those that the board gives each image alone. A board of squares
/// looks much the same from the other side, and so do grains: matching may place images turned
/// about it, with small residuals.
struct BoardAgreement {
  int seen = 0;              ///< images whose corners say something
  int with = 0;              ///< of these, the most whose turns board_from_model agree
  std::vector<int> against;  ///< the others, ascending, as indices into the poses
};
/// @param camera_from_world  of any gauge
/// @param images  of each pose: which of `corners`' entries it is
/// @param most_rad  turns that differ by more do not agree
BoardAgreement board_agreement(const std::vector<Pose>& camera_from_world,
                               const std::vector<int>& images, const Camera& lens,
                               const Corners& corners, const SeedBoard& board, double most_rad,
                               const BoardViewConfig& config = {});

/// The model without some of its images, by their indices in it, ascending; points that fewer than
/// two of the others show go too.
SfmModel without_images(const SfmModel& model, const std::vector<int>& gone);

/// Points of a bundle that are corners of the board, by (row, column).
using CornerPoints = std::map<std::pair<int, int>, int>;

/// Adds images that show the board to a bundle in the board's frame, with their corners as known
/// points; all have its first lens.
/// @param lens  what that lens is by now, to place them with
/// @param images  of the bundle: which of `corners`' entries each is; grows
/// @param points  of the bundle; grows by corners that only the images added show
/// @param sigma_m  of each coordinate of a corner of the print
/// @param floor_px  added in quadrature to each corner's deviation
/// @returns the entries that were added, ascending
std::vector<int> add_board_views(const Camera& lens, const Corners& corners, const SeedBoard& board,
                                 double sigma_m, double floor_px, const BoardViewConfig& config,
                                 BundleAdjustmentInput& bundle, std::vector<int>& images,
                                 CornerPoints& points);

}  // namespace cousin
