#pragma once

#include "benchmarks/seeds/simulate.h"

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
RenderNoise measure_render_noise(const SeedsSimulation& simulation, const PhoneConfig& sensor,
                                 int frame);

/// PSNR between two captures of the same views that differ in their noise alone, mean over `views`
/// of them evenly spread: what a model without noise has is 3.0 dB above.
/// @throws std::invalid_argument unless 1 <= views <= those that there are
double noise_floor_psnr_db(const SeedsSimulation& simulation, int views);

}  // namespace cousin
