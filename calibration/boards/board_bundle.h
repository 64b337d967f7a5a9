#pragma once

#include <vector>

#include "calibration/boards/board_poses.h"
#include "calibration/boards/planar_pose.h"

namespace cousin {

/// One view that goes into the bundle adjustment, with its start.
struct BundleView {
  Camera reported;
  std::vector<BoardPoint> points;
  Pose camera_from_board;  ///< at the middle row
  double readout_s = 0;    ///< 0: all rows at once
};

struct BundleResult {
  struct View {
    Pose camera_from_board;
    Camera camera;
    Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
    double rms_px = kNaN;
  };
  bool converged = false;
  bool adjusted = false;    ///< false: built without Ceres, the views are as they came
  std::vector<View> views;  ///< same order
  double misfit = 0;        ///< robust root mean square of the residuals, in their sigmas
};

/// Least squares over all views (Ceres, one thread). Pixel of point X in a view, read at row v of
/// H:
///   camera(exp(a u) (R X + t) + b u),  u = (v - (H - 1) / 2) / (H - 1),
/// where a, b are the hand's turn and shift during readout with a prior from the configured hand;
/// camera is the reported one with focal length f (1 + s) (1 + j), s shared, j of the view, and
/// shared offsets of principal point and distortion, all with priors. Cauchy loss at 3 sigma.
/// With `is_bent` three shared bends b, each with a prior, lift X off the plane by
///   b0 (x^2 - 1/3) + b1 x y + b2 (y^2 - 1/3),
/// where x and y are its coordinates over 0.05 m. Built without Ceres the starts come back with the
/// reported lens and zero covariance.
BundleResult bundle_adjust(const std::vector<BundleView>& views, const BoardPosesConfig& config,
                           bool is_bent = false);

}  // namespace cousin
