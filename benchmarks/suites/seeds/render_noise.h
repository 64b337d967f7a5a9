#pragma once

#include "benchmarks/loop/simulate.h"
#include "perception/segment/green.h"

namespace cousin {

/// The renderer's own noise against the sensor's. From two independent renders a and b of a view
/// (other light cache, other pixel samples) a pixel's Monte-Carlo variance is (a - b)^2 / 2,
/// unbiased.
struct RenderNoise {
  double mean_ratio = 0;  ///< mean over pixels and channels of Monte-Carlo variance over the
                          ///< sensor's variance there
  double ratio_of_means = 0;
  double median_ratio = 0;
  long long pixels = 0;
};
RenderNoise measure_render_noise(const Simulation& simulation, const PhoneConfig& sensor,
                                 int frame);

/// PSNR between two captures of the same views that differ in their noise alone, both without their
/// lens, as models are scored (which changes these by 0.1 dB at most): means over
/// views evenly spread. What a model without noise has is 3.0 dB above.
struct NoiseFloor {
  double psnr_db = 0;         ///< of whole photographs
  double psnr_object_db = 0;  ///< over what is not green in the first
  double psnr_whole_db = 0;   ///< the same over all pixels, the green ones being black in both
};
/// @throws std::invalid_argument unless 1 <= views <= those that there are
NoiseFloor measure_noise_floor(const Simulation& simulation, const GreenConfig& green, int views);

}  // namespace cousin
