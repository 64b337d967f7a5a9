#pragma once

#include <limits>

#include "sim/types/seams.h"

namespace cousin {

/// How noisy a cloud is, by its points of the board's face z = 0.
struct BoardNoise {
  double offset_m = 0;  ///< where most of the face's points lie
  double sigma_m = std::numeric_limits<double>::quiet_NaN();  ///< robust, of a point
  /// Robust, of the mean over a patch: what its points err by together.
  double patch_sigma_m = std::numeric_limits<double>::quiet_NaN();
  int patches = 0;  ///< that hold at least 5 points
};
/// Objects stand on the face, nothing is below it: spreads are those of the lower half of the
/// heights, about the mode of all, and of the patches' means in the same way.
/// @param plate_m  side of the board's square about the origin; its outer eighths are left out
/// @param patch_m  side of a patch, > 0: what one window of the depth's matching covers
/// @throws std::invalid_argument if a size is not positive.
BoardNoise board_noise(const Cloud& cloud, double plate_m, double patch_m);

}  // namespace cousin
