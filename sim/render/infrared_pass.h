#pragma once

#include <span>

#include "sim/config/fields.h"
#include "sim/render/ray_scene.h"
#include "sim/truth/truth_images.h"
#include "sim/types/rng.h"

namespace cousin {

/// How a scene looks near 850 nm. The scene's lights are given in the visible: their strength in
/// the infrared is the mean of the three colours times a share.
struct InfraredConfig {
  int pixel_samples = 4;  ///< a square number
  double sun_share = 0.6;
  double sky_share = 0.2;
  double lamp_share = 0.0;
  double speckle_contrast = 0.15;  ///< sigma over mean of the projectors' light in a pixel
};
Fields fields(InfraredConfig& config);
/// @throws std::invalid_argument naming the field, its value and the limit.
void validate(const InfraredConfig& config);

struct InfraredImage {
  Image<float> radiance;   ///< averaged over the pixel; 0 where no surface or lens ray is
  Image<float> projected;  ///< share of the pixel's samples on a surface that some projector lights
};

/// Radiance at 850 nm by direct light only: `projectors` and the scene's own (point sources: 1/d^2,
/// cosine, shadow ray, picture looked up by quadratic B-splines,
/// which have no kinks; the red channel of their intensity counts),
/// suns (one shadow ray at the disk's centre), lamps (as points that throw the shadows of their
/// faces) and skies and environments (their mean; a shadow ray a sample, shared by 4 x 4 pixels of
/// one surface; their lower half stands for the ground's light and casts none). Surfaces are
/// Lambertian with the material's infrared albedo and transmittance, varied by its noise texture as
/// the visible albedo is; prints are black in ink.
///
/// A pixel's samples stand at the middles of its equal squares, and the projectors' pictures are
/// widened to these squares: random places and sharp dots would leave more noise than an imager
/// has.
///
/// Speckle: the projectors' light in a pixel is multiplied by a Gamma variable of mean 1
/// [Goodman 2007], fixed by `rng`, the pixel and the place of the surface seen to 1/8 of the
/// pixel's footprint: a static scene keeps its speckle from image to image, a moved one draws anew,
/// and two imagers with different `rng` see different speckle. Drawn by Wilson and Hilferty's cube.
/// @param rng  pixel (x, y) draws from a hash of its key and the pixel: threads change nothing.
/// @throws std::invalid_argument for an invalid configuration, camera or light, or a scene that is
/// not the one of the rays.
InfraredImage render_infrared(const RayScene& rays, const Scene& scene, const TrueView& view,
                              std::span<const Projector> projectors, const InfraredConfig& config,
                              Rng rng);

}  // namespace cousin
