#pragma once

#include "sim/config/fields.h"
#include "sim/types/board.h"
#include "sim/types/capture.h"
#include "sim/types/seams.h"

namespace cousin {

struct BoardDetectionConfig {
  int min_corners = 12;  ///< fewer: the view is not used
  double window_squares =
      0.5;  ///< half of a corner's window, in squares; windows up to 0.5 share no pixel
  double max_sigma_px = 0.5;         ///< corners predicted worse than this are dropped
  double saddle_smoothing_px = 1.0;  ///< Gaussian before the search for saddles
  double saddle_contrast =
      0.008;  ///< least sqrt(-det Hessian) of a saddle, of the full sRGB range, per px^2
  double min_correlation =
      0.5;  ///< of the image with the print, below which the board is not accepted
  double min_preference =
      0.15;  ///< least correlation of the image with the difference of the two best placements
  double max_turn_rad = 0.6;  ///< plain board: largest turn between two views used
};
Fields fields(BoardDetectionConfig& config);
void validate(const BoardDetectionConfig& config);

/// Finds the seed board although seeds cover part of it, in the first sensor's images:
/// 1. saddles of the image grow into a lattice of checkerboard corners from any visible cell
/// outward;
/// 2. each placement of the lattice on the board (four turns, all shifts) is scored by the
/// correlation of the image
///    with the print seen through the reported lens: the markers decide;
/// 3. the print's template is moved onto the image in a window about each corner (least squares in
/// linear light),
///    outward until no corner is added; seeds and shadows fail the fit's residual.
/// Where 1 finds nothing, it is tried again in the plate turned upright by its outline on the green
/// screen; where that finds nothing, the print as a whole is moved onto the plate's outline.
/// A plain board looks the same after a quarter turn: the steepest view defines the frame, and the
/// turns of the others are chosen together, so that the specimens lie where all views see them and
/// neighbours in time turn little. A view for which two turns do nearly as well is `ambiguous`. On
/// an empty board, a path that leaps by more than an eighth of a turn goes wrong unnoticed.
/// One entry for each frame; covariance_px2 is predicted from each fit's own residual.
Corners detect_board(const Capture& capture, const SeedBoard& board,
                     const BoardDetectionConfig& config = {});

}  // namespace cousin
