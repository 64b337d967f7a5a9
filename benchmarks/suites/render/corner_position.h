#pragma once

#include <Eigen/Core>

#include "sim/types/camera.h"

namespace cousin {

/// A plausible camera of each lens model with strong distortion; fy is 1 % larger than fx, and the
/// principal point a few pixels off the middle.
Camera strong_lens(LensModel model, int width_px, int height_px, double focal_px);

/// Where the corners of the seed board appear in a rendered image against where they project; NaN
/// if none was seen.
struct CornerPositions {
  int corners = 0;
  Eigen::Vector2d bias_px = Eigen::Vector2d::Zero();  ///< mean of (rendered - projected)
  double rms_px = 0;                                  ///< of one coordinate
};

/// Renders the board alone, evenly lit, without noise, through a lens of strong distortion at
/// 240 x 200, rolled so that edges cross the pixels at all phases, and locates every corner at the
/// point that all edges in a window pass through [Foerstner & Guelch 1987].
CornerPositions measure_corner_positions(LensModel model);

}  // namespace cousin
