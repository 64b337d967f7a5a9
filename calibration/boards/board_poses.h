#pragma once

#include "sim/config/fields.h"
#include "sim/types/board.h"
#include "sim/types/capture.h"
#include "sim/types/seams.h"

namespace cousin {

struct BoardPosesConfig {
  bool refine_lens =
      true;  ///< shared principal point, distortion, and focal length law over all views
  int min_views_for_lens = 3;  ///< with fewer views the lens stays as reported
  double focal_prior = 0.005;  ///< relative sigma of the reported focal lengths' common factor
  double focal_jitter =
      0.0003;             ///< relative sigma of one image's focal length about the reported law
  bool focus_law = true;  ///< images' focal lengths follow the thin lens law, if they do
  double focus_law_jitter = 1e-4;  ///< relative sigma of one image's focal length about that law
  double centre_prior_px_per_width = 0.005;
  double distortion_prior = 0.02;  ///< sigma of each coefficient about the reported one
  /// Sigma of the bends of a printed sheet, which are solved for where corners fit a plane badly
  /// (by more than three sigmas) and the lens is refined; 0 = every board is flat.
  double sheet_bend_m = 0.0005;
  double hand_speed_m_per_s =
      0.02;  ///< sigma of the camera's velocity while a rolling shutter reads; 0 = still
  double hand_rate_rad_per_s = 0.02;  ///< sigma of its turning rate
  double corner_floor_px = 0.003;     ///< added in quadrature to each corner's predicted sigma
  double max_rms_px = 2;              ///< a view whose corners fit worse is `not_converged`
  int max_iterations = 100;
};
Fields fields(BoardPosesConfig& config);
void validate(const BoardPosesConfig& config);

/// Poses of all views from board corners: planar PnP per view, then one bundle adjustment (Ceres)
/// over all views with shared lens, per-image focal length, the hand's motion during readout, and a
/// robust loss. A board in one plane hardly tells focal length from distance, and the focal length
/// that a phone reports for an image is as wrong as its focus scale; so where the reported ones
/// follow A (1 + f / (d - f)) over the distances d first found, they are replaced by that law and
/// the adjustment is made again. Each pose has a covariance per pose, with the shared lens'
/// uncertainty. `world` is the board's frame (metric). A view's pose is that of its middle row.
/// Status: `no_board` where the corners are not ok; `degenerate` for fewer than four corners or
/// corners on a line; `not_converged` where the solver stopped early or the fit is worse than
/// `max_rms_px`. Built without Ceres: PnP through the reported lens only, covariance zero
/// (unknown).
/// @throws std::invalid_argument if corners and frames do not match or a corner is not on the board
Poses estimate_board_poses(const Capture& capture, const Corners& corners, const SeedBoard& board,
                           const BoardPosesConfig& config = {});

}  // namespace cousin
