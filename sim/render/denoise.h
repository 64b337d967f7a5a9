#pragma once

#include "sim/config/fields.h"
#include "sim/render/path_tracer.h"
#include "sim/truth/truth_images.h"

namespace cousin {

/// For pictures that people look at. Never for images that a sensor model or a measurement reads:
/// what remains of the noise is correlated between pixels, and detail below it is gone.
struct DenoiseConfig {
  int radius_px = 7;           ///< of the window whose pixels are averaged
  double color_sigmas = 0.7;   ///< how unlike, in standard deviations of their noise, colours are
  double normal_degrees = 12;  ///< angle between normals at which a weight falls to 1 / e
  double distance_px = 2;  ///< how far off the pixel's tangent plane, in widths of a pixel there
};
Fields fields(DenoiseConfig& config);
/// @throws std::invalid_argument naming the field, its value and the limit.
void validate(const DenoiseConfig& config);

/// Weighted means over a window: the colours of two patches of 3 x 3 pixels must agree within their
/// estimated errors, and the surfaces behind the two pixels in normal and tangent plane
/// [Rousselle, Manzi & Zwicker 2013, with features that carry no noise]. A pixel whose own error is
/// 0 stays as it is.
/// @param guide  depth, normals and positions of the same view; pixels without a surface are
/// averaged with their like. @throws std::invalid_argument if sizes differ or an image is missing.
Image<Rgbf> denoise(const PathImage& noisy, const TrueView& view, const TruthImages& guide,
                    const DenoiseConfig& config);

}  // namespace cousin
