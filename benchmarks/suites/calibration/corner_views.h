#pragma once

#include <vector>

#include "calibration/solve/calibrate.h"
#include "sim/types/pose.h"
#include "sim/types/rng.h"

namespace cousin {

/// What is wrong with a board, a shutter or a detector beside noise. All 0 and 1: nothing.
struct CornerFlaws {
  double stretch_x = 1;  ///< true pitch across over the designed
  double shear = 0;      ///< x += shear * y
  double edge_m = 0;     ///< an end bends up: z += edge ((1 + y) / 2)^2, y from -1 to 1
  double twist_m = 0;    ///< a corner lifts: z += twist x y, x and y from -1 to 1
  double flutter_m = 0;  ///< deviation of the bend along each axis, drawn anew for each frame
  double turn_rad = 0;   ///< deviation of the turn about each axis while the rows are read
  Eigen::Vector2d shift_px = Eigen::Vector2d::Zero();  ///< by which each corner is found off
};

/// Corners of a chessboard as cameras would see them, computed, not photographed: for what solvers
/// do with corners whose noise is known exactly.
struct CornerViewsConfig {
  int columns = 8, rows = 5;  ///< inner corners
  double pitch_m = 0.025;
  int frames = 30;
  double tilt_rad = 0.7;  ///< largest, about each of the board's axes
  double roll_rad = 0.5;
  double near_m = 0.3, far_m = 0.6;
  double noise_px = 0.1;  ///< of each coordinate
  double outlier_share = 0;
  double outlier_px = 10;  ///< largest shift of an outlier along each axis
  Eigen::Vector2d deformation_m = Eigen::Vector2d::Zero();
  CornerFlaws flaws;
  /// Where the board's middle lies in camera 0's image, as shares of it: low corner, high corner.
  Eigen::Vector4d region{0, 0, 1, 1};
  bool whole = true;  ///< only views that camera 0 sees whole; else at least twelve corners
};

struct CornerViews {
  CalibrationInput input;
  std::vector<Camera> cameras;              ///< true
  std::vector<Pose> camera_from_rig;        ///< true
  std::vector<Pose> rig_from_target;        ///< true, by frame
  std::vector<std::vector<bool>> outliers;  ///< for each view's points
};

/// Cameras of the input have the true model and size, and no start.
/// @throws std::runtime_error if the board does not fit into the image in 10 000 draws
CornerViews make_corner_views(const std::vector<Camera>& cameras,
                              const std::vector<Pose>& camera_from_rig,
                              const CornerViewsConfig& config, const Rng& rng);

/// 640 x 480: pinhole and opencv5 are like the Strawberries paper's colour camera; opencv8 and 12
/// (with thin prisms) have a ratio that a polynomial cannot stand for, 110 degrees across; a
/// fisheye of 120 degrees for Kannala-Brandt; a smooth bend of 100 degrees for splines.
Camera study_camera(LensModel model);

}  // namespace cousin
