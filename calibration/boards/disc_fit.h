#pragma once

#include <Eigen/Core>
#include <optional>

#include "sim/types/image.h"

namespace cousin {

/// A dark disc on white as an image shows it: an ellipse whose edge is blurred.
struct DiscFit {
  Eigen::Vector2d centre_px;  ///< of the ellipse, which is not where the disc's centre is seen
  /// Points x of the outline have (x - centre)' shape (x - centre) = 1; 1/px^2.
  Eigen::Matrix2d shape;
  Eigen::Matrix2d unit_covariance_px2;  ///< of the centre, for noise of 1 in every pixel
  double noise = 0;                     ///< RMS that the fit leaves at the edge, per pixel
  double contrast = 0;                  ///< white less black
  double blur_px = 0;
  int pixels = 0;
};

/// Least squares of signal = black + (white - black) Phi(d / blur), d the signed distance to the
/// ellipse to first order, by Levenberg-Marquardt over centre, shape, levels and blur.
/// @param start_px, radius_px  roughly
/// @param reach_px             pixels farther than this outside the outline are not looked at
/// Nothing where it leaves the image, its start, or does not converge.
std::optional<DiscFit> fit_disc(const Image<float>& signal, const Eigen::Vector2d& start_px,
                                double radius_px, double reach_px);

/// Where the centre of a disc of a plane is seen, less the centre of the ellipse that its outline
/// is seen as [Heikkila & Silven, CVPR 1997], in pixels.
/// @param pixel_from_plane  homography @param radius_m in the plane
Eigen::Vector2d disc_centre_shift_px(const Eigen::Matrix3d& pixel_from_plane,
                                     const Eigen::Vector2d& centre_m, double radius_m);

}  // namespace cousin
