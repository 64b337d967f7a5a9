#pragma once

#include <memory>

#include "sim/config/fields.h"
#include "sim/render/ray_scene.h"
#include "sim/truth/truth_images.h"
#include "sim/types/rng.h"

namespace cousin {

struct RadianceConfig {
  int pixel_samples = 4;        ///< a pixel, at least 4; a square number
  int edge_samples = 144;       ///< a pixel where surface, print or shade changes; a square number
  int irradiance_samples = 64;  ///< paths a point of the irradiance cache
  int max_bounces = 4;          ///< diffuse bounces of those paths
  double board_texel_m = 0.0004;  ///< spacing of cache points on specimens and on the print
};
Fields fields(RadianceConfig& config);
/// @throws std::invalid_argument naming the field, its value and the limit.
void validate(const RadianceConfig& config);

/// Diffuse irradiance of a static scene, computed once by path tracing with next-event estimation
/// and shared by all views. Points: vertices of finely meshed specimens, a lattice of
/// `board_texel_m` on other specimens and on the print, of 1/48 of its size on everything else.
/// Lamps and sky are cached; a sun is not, as its shadows are sharp: it is sampled at every hit.
/// The back of a closed surface is black; an open one has both sides.
class IrradianceCache {
 public:
  /// @param rays  must outlive the cache.  @param rng  point i draws from a hash of its key and i.
  /// @throws std::invalid_argument for an invalid configuration or light.
  IrradianceCache(const RayScene& rays, const Scene& scene, const RadianceConfig& config, Rng rng);
  ~IrradianceCache();
  IrradianceCache(IrradianceCache&&) noexcept;
  struct Impl;
  const Impl& impl() const { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

/// Linear radiance (sRGB primaries) averaged over each pixel's square, through the true lens per
/// ray: albedo * irradiance / pi under the coat, and the coat's reflection of lights, sky and
/// scene, sampled per view. Rays to sub-pixel positions interpolate between the exact directions of
/// the pixel's corners: within 1e-3 px for lenses whose scale changes by less than 1 % a pixel.
/// Pixels without rays are black. Pixels whose `pixel_samples` differ in instance, print, sunlight
/// or by 10 % in diffuse radiance, and pixels beside such a one or beside another surface, are
/// drawn anew with `edge_samples`.
/// @param rng  pixel (x, y) draws from a hash of its key and the pixel: threads change nothing.
Image<Rgbf> render_radiance(const RayScene& rays, const Scene& scene, const IrradianceCache& cache,
                            const TrueView& view, const RadianceConfig& config, Rng rng);

}  // namespace cousin
