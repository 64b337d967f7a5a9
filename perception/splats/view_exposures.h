#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "perception/splats/splat_views.h"

namespace cousin {

/// How a lens darkens towards its corners: ln of light less that on the axis is a r^2 + b r^4, r
/// from the principal point over the image's half diagonal.
struct Vignetting {
  double a = 0, b = 0;
  double log_at(double r2) const { return r2 * (a + r2 * b); }
};

enum class ExposureStatus {
  ok,
  too_few_views,     ///< two at least
  too_few_sightings  ///< no two views share enough surface
};

/// What photographs of one scene differ by though its light is one: automatic exposure gives each a
/// factor, the lens darkens all alike. White balance is taken to be fixed.
struct ViewExposures {
  ExposureStatus status = ExposureStatus::too_few_views;
  /// One for each view: ln of its light over that of the views' geometric mean; NaN = it shares too
  /// little surface with the others.
  std::vector<double> log_gain;
  /// Of each, from the sightings' scatter; NaN likewise. What shines or is in the shade of a view
  /// alone is not in it.
  std::vector<double> sigma;
  Vignetting vignetting;
  double vignetting_sigma = kNaN;  ///< of ln of light in the corners (r = 1)
  double scatter = kNaN;           ///< robust standard deviation of ln of light that is left
  std::int64_t points = 0, sightings = 0;

  /// ln of the view's factor; zero where it is not known.
  double gain_of(std::size_t view) const;
};

struct ExposureConfig {
  int stride_px = 2;  ///< between pixels of a depth image whose surface is followed
  double depth_agreement =
      0.02;                 ///< relative: views whose depths differ by more show different surfaces
  double darkest = 0.1;     ///< encoded, the mean of the channels of what counts
  double brightest = 0.97;  ///< encoded, each of them
  int least_sightings = 50;  ///< that two views share, to say one's beside the other's
};
void validate(const ExposureConfig& config);  ///< throws std::invalid_argument

/// Exposures and vignetting from surfaces that several views show: at each pixel with depth the
/// surface's light in all views that have the same surface there; ln of light = surface + view +
/// vignetting, by least squares with Cauchy's weights, since surfaces shine and depths err
/// (Goldman, TPAMI 32(12), 2010, has the model; ours is linear in logarithms). Sums of ln of gains
/// are zero. A view with too few depths of its own counts where other views' surfaces should be in
/// it.
/// @param depths_m  one for each view, of its size: depth along the axis, NaN = none; empty = none
/// Where surfaces are in the middle of the images alone, vignetting is held near none.
/// @throws std::invalid_argument if counts or sizes differ or the configuration is invalid.
ViewExposures estimate_exposures(std::span<const SplatView> views,
                                 std::span<const Image<float>> depths_m,
                                 const ExposureConfig& config = {});

/// The photograph with the views' mean exposure and no vignetting. Colours may exceed 1.
SplatViewLevel at_mean_exposure(SplatViewLevel level, double log_gain,
                                const Vignetting& vignetting);
/// The other way: an image of mean exposure as a camera of that exposure and lens shows it, 0..1;
/// NaN stays.
ColorPlanes as_exposed(ColorPlanes image, const Camera& camera, double log_gain,
                       const Vignetting& vignetting);

}  // namespace cousin
