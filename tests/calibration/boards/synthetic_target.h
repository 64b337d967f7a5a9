#pragma once

#include <Eigen/Core>
#include <map>

#include "calibration/boards/charuco_layout.h"
#include "sim/types/calibration_target.h"
#include "sim/types/camera.h"
#include "sim/types/image.h"
#include "sim/types/pose.h"
#include "sim/types/rng.h"

namespace cousin::synthetic {

struct TargetImageConfig {
  double blur_px = 1;  ///< Gaussian on top of the pixel's square
  double noise = 0;    ///< of the range from black to white
  double black = 0.05;
  double white = 0.85;
  double background = 0.3;  ///< beyond the print and its white margin
  CharucoLayout layout = CharucoLayout::current;
  int samples = 12;  ///< a side, in pixels that an edge crosses
  bool swap_colors = false;
};

/// A picture of a print made without any mesh or renderer: the share of ink in each pixel through
/// the lens, blurred, with noise.
struct TargetShot {
  Image<float> light;
  std::map<int, Eigen::Vector2d> true_px;  ///< of the points inside the picture
};
TargetShot shoot_target(const CalibrationTarget& target, const Camera& camera,
                        const Pose& camera_from_target, const TargetImageConfig& config, Rng rng);

/// Whether ink is at a point of the print as designed.
bool is_ink(const CalibrationTarget& target, const Eigen::Vector2d& at_m);

/// Facing the camera, turned about an axis in the picture, then rolled.
Pose tilted(double distance_m, double tilt_rad, double axis_rad, double roll_rad,
            const Eigen::Vector2d& shift_m = Eigen::Vector2d::Zero());

}  // namespace cousin::synthetic
