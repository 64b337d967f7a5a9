#pragma once

#include <Eigen/Core>
#include <vector>

#include "calibration/boards/board_template.h"
#include "sim/types/image.h"

namespace cousin {

/// One corner measured by moving the template's window about it onto the image.
struct CornerFit {
  int column = 0;
  int row = 0;
  Eigen::Vector2d pixel_px;  ///< predicted place plus measured shift
  Eigen::Vector2d shift_px;
  double offset = 0;    ///< linear signal of black
  double contrast = 0;  ///< linear signal of white minus black
  double noise = 0;     ///< RMS of what the fit leaves, over the contrast
  /// Predicted, of the shift, for noise of 1 (times `noise` squared gives square pixels).
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Zero();
  int pixels = 0;
  PixelBox window;  ///< within the template's box
};

/// Fits signal = a + b white(x - shift) in the window of each corner that lies in the image: a
/// window is the part of the board within `window_squares` of the corner, so windows of half a
/// square share no pixel. Least squares in (a, b, b shift), linear in the shift; windows with fewer
/// than 8 pixels are left out.
std::vector<CornerFit> fit_corners(const Image<float>& linear, const SeedBoard& board,
                                   const Camera& camera,
                                   const Eigen::Matrix3d& normalized_from_board,
                                   const BoardTemplate& t, double window_squares);

/// The blur (px) that explains the windows better: a Newton step on its square along
/// d(white)/d(blur^2), which is half the template's Laplacian.
double refined_blur_px(const Image<float>& linear, const BoardTemplate& t,
                       const std::vector<CornerFit>& fits, double window_squares, double blur_px);

}  // namespace cousin
