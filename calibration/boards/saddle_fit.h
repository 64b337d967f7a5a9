#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>

#include "sim/types/image.h"

namespace cousin {

/// The blurred corner where two black squares touch: the product of the signs of the distances u
/// and v to two lines through it, under a Gaussian of one unit. -1..1.
struct SaddleValue {
  double value = 0;
  double d_u = 0, d_v = 0;
  double d_correlation = 0;
};
/// E[sgn(u + m) sgn(v + n)] for unit normals m, n with the correlation given, which is the cosine
/// of the angle between the lines' normals: erf(u/sqrt2) erf(v/sqrt2) plus the integral of four
/// bivariate densities from correlation 0 on [Plackett, Biometrika 1954], by ten Gauss-Legendre
/// nodes in its arcsine [Genz, Statistics and Computing 2004]. |correlation| < 1.
SaddleValue blurred_saddle(double u, double v, double correlation);

/// Where a corner is thought to be.
struct SaddleStart {
  Eigen::Vector2d pixel_px;
  Eigen::Vector2d along_first, along_second;  ///< directions of its two edges; any length
  double blur_px = 1;
};

struct SaddleFitConfig {
  int half_window_px = 5;       ///< a square of 2 h + 1 pixels
  double max_shift_px = 2;      ///< from where it starts
  int min_pixels = 12;          ///< of the window that belong to the corner
  int max_iterations = 40;      ///< of Levenberg-Marquardt
  double min_edge_angle = 0.1;  ///< least sine of the angle between the edges
};

/// A corner placed in its window.
struct SaddleFit {
  Eigen::Vector2d pixel_px;
  /// Of the place for noise of 1 in every pixel; times `noise` squared: square pixels.
  Eigen::Matrix2d unit_covariance_px2;
  double noise = 0;         ///< RMS that the fit leaves where the place shows, per pixel
  double contrast = 0;      ///< white less black
  double black = 0;         ///< signal between the darker edges
  double blur_px = 0;       ///< Gaussian that the edges show, the pixel's own included
  bool dark_ahead = false;  ///< dark between the two given directions
  Eigen::Vector2d along_first, along_second;  ///< unit, of the edges as fitted
  int pixels = 0;
};

/// Least squares of signal = a + b s + c (1 - s^2) over the window, s the blurred saddle, in place,
/// edge directions, blur, levels and c, a tone curve's bend; all derivatives in closed form. By the
/// saddle's point symmetry the place correlates with its derivatives alone.
/// @param signal     linear in light, or nearly: c takes a curve's second order
/// @param is_clear   whether a pixel at this offset from the start shows this corner's squares
/// alone; none asks for all of the window
/// Nothing where the window has too few pixels, the place leaves its bounds, or nothing converges.
std::optional<SaddleFit> fit_saddle(
    const Image<float>& signal, const SaddleStart& start, const SaddleFitConfig& config = {},
    const std::function<bool(const Eigen::Vector2d& offset_px)>& is_clear = {});

}  // namespace cousin
