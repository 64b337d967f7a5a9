#pragma once

#include <memory>

#include "sim/config/fields.h"
#include "sim/render/ray_scene.h"
#include "sim/truth/truth_images.h"
#include "sim/types/rng.h"

namespace cousin {

struct PathConfig {
  int pixel_samples = 64;   ///< camera rays a pixel; with `adaptive`, on average
  int max_bounces = 4;      ///< surfaces after the first; 0: light that comes straight to the first
  bool adaptive = false;    ///< more samples where the relative error is larger
  int min_samples = 16;     ///< a pixel, before samples are spread by error
  double target_error = 0;  ///< adaptive: stop when the image's estimated relative error, root mean
                            ///< square, is below; 0 = spend all samples
  bool refracts_sun =
      false;  ///< through water suns and beams shine by refracted paths alone, which
              ///< is right and noisy; else straight, less what each face mirrors
};
Fields fields(PathConfig& config);
/// @throws std::invalid_argument naming the field, its value and the limit.
void validate(const PathConfig& config);

struct PathImage {
  Image<Rgbf> radiance;          ///< linear sRGB; mean over the pixel's square and exposure
  Image<float> luminance_error;  ///< estimated standard error of the pixel's luminance
  Image<std::uint32_t> samples;  ///< spent on the pixel
  std::uint64_t rays = 0;        ///< traced in all, shadows included
};

/// Unbiased light transport by paths from the camera: next-event estimation of suns, lamps, beams
/// and environment pictures, the surface's own directions for everything that shines, both weighed
/// by the power heuristic [Veach 1997]; Russian roulette by throughput. First hits and shadow rays
/// travel in packets. A path that meets the back of a closed opaque surface ends there, black.
/// Not exact: suns and beams through water (`PathConfig::refracts_sun`).
/// Immutable after construction; holds float copies of what light needs of the scene.
class PathTracer {
 public:
  /// @param rays  must outlive the tracer.
  /// @throws std::invalid_argument for an invalid material or light, naming it.
  PathTracer(const RayScene& rays, const Scene& scene);
  ~PathTracer();
  PathTracer(PathTracer&&) noexcept;

  /// One view through the true lens: per-ray distortion, rolling shutter per row, thin-lens depth
  /// of field, motion during the exposure at 8 instants a row. Pixels without rays are black.
  /// @param rng  pixel (x, y) draws from a hash of its key, the pixel and the sample's number: the
  /// same bytes on any number of threads.
  PathImage render(const TrueView& view, const PathConfig& config, Rng rng) const;

  struct Impl;

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace cousin
