#pragma once

#include <Eigen/Geometry>

#include "sim/types/camera.h"

namespace cousin {

/// How far a lens that was calibrated is from the true one, in pixels and in what is measured with
/// it. NaN where the estimate cannot be evaluated: it folds inside the image.
struct CalibrationErrors {
  /// Of where points at infinity fall, over the whole image, after the rotation of the camera that
  /// explains most of it: what no pose can take up. RMS of the distance and the largest.
  double projection_px = 0, projection_worst_px = 0;
  /// Of the place of a fruit 0.5 m away whose depth is known exactly, sideways, RMS over the
  /// image: ray times depth, as a gripper on the same body takes it, with no rotation taken up.
  double fruit_m = 0;
  /// Of the length of a seed of 10 mm on the seed board, between its two ends, each where the rays
  /// of a ring of views meet; the views' poses come from the board's own corners through the same
  /// lens. RMS over 24 seeds.
  double seed_m = 0;
};

/// Rotation R of the camera such that `estimate` sees R d where `truth` sees d, by least squares
/// over a lattice of the image.
struct ImpliedRotation {
  Eigen::Matrix3d estimate_from_truth = Eigen::Matrix3d::Identity();
  double rms_px = 0, worst_px = 0;  ///< what is left, distance
};
/// NaN where a direction of the image has no pixel in `estimate`.
ImpliedRotation implied_rotation(const Camera& truth, const Camera& estimate);

/// @param estimate  of the same image size
CalibrationErrors calibration_errors(const Camera& truth, const Camera& estimate);

}  // namespace cousin
