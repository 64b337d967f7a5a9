#pragma once

#include "sim/types/camera.h"

namespace cousin {

/// How far a lens that was calibrated is from the true one, in pixels and in what is measured with
/// it. NaN where the estimate cannot be evaluated: it folds inside the image.
struct CalibrationErrors {
  /// projection_difference at infinity: what no pose can take up. RMS over the image and the
  /// largest.
  double projection_px = 0, projection_worst_px = 0;
  /// Of the place of a fruit 0.5 m away whose depth is known exactly, sideways, RMS over the
  /// image: ray times depth, as a gripper on the same body takes it, with no rotation taken up.
  double fruit_m = 0;
  /// Of the length of a seed of 10 mm on the seed board, between its two ends, each where the rays
  /// of a ring of views meet; the views' poses come from the board's own corners through the same
  /// lens. RMS over 24 seeds.
  double seed_m = 0;
};

/// @param estimate  of the same image size
CalibrationErrors calibration_errors(const Camera& truth, const Camera& estimate);

}  // namespace cousin
