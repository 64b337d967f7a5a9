#include "sim/sensors/photosites.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/sensors/fast_normal.h"

namespace cousin {
namespace {

// Automatic exposure, free: as phones do, it lets the brightest half per cent go and leaves a fifth
// of the full well to what a picture does not show. No phone's metering is documented.
constexpr double kAutoQuantile = 0.995;
/// Above, a normal distribution corrected for skewness stands for Poisson's.
constexpr float kExactPoissonBelow_e = 30;

}  // namespace

void expose_row(std::span<const float> signal, const float* prnu, const float* dsnu,
                const Exposure& exposure, Rng rng, std::uint16_t* codes) {
  const NormalTable& table = normal_table();
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < signal.size(); ++i) {
    bits = i % 2 == 0 ? rng() : bits >> 32;
    const float z = table(static_cast<std::uint32_t>(bits));
    float mean = std::max(0.0F, signal[i] * exposure.electrons * prnu[i]) + exposure.dark_e;
    float electrons;
    if (mean < kExactPoissonBelow_e) {
      mean = static_cast<float>(poisson(rng, mean));
      electrons = mean + std::sqrt(exposure.read_variance) * z;
    } else {
      // Cornish-Fisher: the skewness of the sum is the Poisson's alone. The term's own variance, 2
      // s^2, is taken from the normal part.
      const float variance = mean + exposure.read_variance;
      const float skew = mean / (6 * variance);
      electrons = mean + std::sqrt(variance - 2 * skew * skew) * z + skew * (z * z - 1);
    }
    const float code =
        exposure.black_code + ((electrons + dsnu[i]) + exposure.offset_e) * exposure.codes_per_e;
    codes[i] = static_cast<std::uint16_t>(std::clamp(code, 0.0F, exposure.max_code) + 0.5F);
  }
}

void fixed_pattern_row(std::span<float> row, double mean, double sigma, Rng rng) {
  const NormalTable& table = normal_table();
  for (float& value : row) {
    value = static_cast<float>(mean + sigma * table(static_cast<std::uint32_t>(rng() >> 32)));
  }
}

double auto_exposure_electrons(std::vector<float> signals, double full_well_e) {
  if (signals.empty())
    throw std::invalid_argument("automatic exposure: the radiance image is empty");
  const auto rank =
      static_cast<std::ptrdiff_t>(kAutoQuantile * static_cast<double>(signals.size() - 1));
  std::nth_element(signals.begin(), signals.begin() + rank, signals.end());
  const double quantile = signals[static_cast<std::size_t>(rank)];
  return kAutoFullWellShare * full_well_e / (quantile > 1e-9 ? quantile : 1.0);
}

}  // namespace cousin
