#include "sim/sensors/infrared_imager.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/config/limits.h"
#include "sim/sensors/fast_normal.h"
#include "sim/sensors/optics.h"

namespace cousin {
namespace {

constexpr double kBrightQuantile = 0.995;

/// Rows about y, then columns; borders repeat.
void blur_row(const Image<float>& image, const std::vector<float>& weights, int y,
              std::vector<float>& column, std::vector<float>& out) {
  const int width = image.width(), radius = static_cast<int>(weights.size() / 2);
  column.assign(static_cast<std::size_t>(width + 2 * radius), 0.0F);
  for (int t = -radius; t <= radius; ++t) {
    const float* row = image.row(std::clamp(y + t, 0, image.height() - 1)).data();
    const float weight = weights[static_cast<std::size_t>(t + radius)];
    float* to = column.data() + radius;
    for (int x = 0; x < width; ++x) to[x] += weight * row[x];
  }
  std::fill_n(column.begin(), radius, column[static_cast<std::size_t>(radius)]);
  std::fill(column.end() - radius, column.end(),
            column[static_cast<std::size_t>(radius + width - 1)]);
  out.assign(static_cast<std::size_t>(width), 0.0F);
  for (std::size_t t = 0; t < weights.size(); ++t) {
    for (std::size_t x = 0; x < out.size(); ++x) out[x] += weights[t] * column[x + t];
  }
}

}  // namespace

Fields fields(InfraredImagerConfig& c) {
  return {
      {"electrons_at_unit_radiance", &c.electrons_at_unit_radiance,
       "electrons at radiance 1 and the longest exposure", 1e-3, 1e12},
      {"full_well_e", &c.full_well_e, "saturation", 10, 1e7},
      {"read_noise_e", &c.read_noise_e, "sigma of the read noise", 0, 1e4},
      {"prnu", &c.prnu, "relative sigma of the pixels' response", 0, 0.2},
      {"bits", &c.bits, "of the codes", 8, 16},
      {"target", &c.target, "automatic exposure: share of full well of the brightest", 0.01, 2},
      {"least_exposure", &c.least_exposure, "shortest exposure over the longest", 1e-9, 1},
      {"largest_gain", &c.largest_gain, "analogue gain", 1, 1e3},
      {"blur_sigma_px", &c.blur_sigma_px, "Gaussian blur of lens and pixel", 0, 10},
  };
}

void validate(const InfraredImagerConfig& config) {
  InfraredImagerConfig copy = config;
  check_limits(fields(copy), "imager");
}

InfraredExposure auto_exposure(const Image<float>& radiance, const InfraredImagerConfig& config) {
  validate(config);
  std::vector<float> values(radiance.begin(), radiance.end());
  if (values.empty()) return {};
  const auto at = static_cast<std::ptrdiff_t>(kBrightQuantile * (values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  const double electrons =
      static_cast<double>(values[static_cast<std::size_t>(at)]) * config.electrons_at_unit_radiance;
  const double wanted = config.target * config.full_well_e;
  InfraredExposure exposure;
  if (!(electrons > 0)) return {1, config.largest_gain};
  exposure.share = std::clamp(wanted / electrons, config.least_exposure, 1.0);
  exposure.gain = std::clamp(wanted / (electrons * exposure.share), 1.0, config.largest_gain);
  return exposure;
}

Image<float> response_map(int width, int height, double prnu, const Rng& rng) {
  Image<float> response(width, height);
  const NormalTable& table = normal_table();
  tbb::parallel_for(0, height, [&](int y) {
    Rng row = rng.fork(static_cast<std::uint64_t>(y));
    for (float& value : response.row(y))
      value = 1 + static_cast<float>(prnu) * table(static_cast<std::uint32_t>(row() >> 32));
  });
  return response;
}

Image<std::uint16_t> expose_infrared(const Image<float>& radiance, const Image<float>& response,
                                     const InfraredExposure& exposure,
                                     const InfraredImagerConfig& config, Rng rng) {
  validate(config);
  if (radiance.width() != response.width() || radiance.height() != response.height())
    throw std::invalid_argument("infrared imager: radiance and response differ in size");
  const int width = radiance.width();
  const auto electrons = static_cast<float>(config.electrons_at_unit_radiance * exposure.share);
  const auto full_well = static_cast<float>(config.full_well_e);
  const float largest_code = static_cast<float>((1 << config.bits) - 1);
  const float codes_per_e = largest_code * static_cast<float>(exposure.gain) / full_well;
  const auto read_variance = static_cast<float>(config.read_noise_e * config.read_noise_e);
  const std::vector<float> weights = gaussian_weights(config.blur_sigma_px);
  const NormalTable& table = normal_table();
  Image<std::uint16_t> codes(width, radiance.height());
  tbb::parallel_for(tbb::blocked_range<int>(0, radiance.height(), 16), [&](const auto& range) {
    std::vector<float> column, signal;
    for (int y = range.begin(); y < range.end(); ++y) {
      Rng row = rng.fork(static_cast<std::uint64_t>(y));
      blur_row(radiance, weights, y, column, signal);
      const float* gain = response.row(y).data();
      std::uint16_t* out = codes.row(y).data();
      for (int x = 0; x < width; ++x) {
        const float mean =
            std::max(0.0F, signal[static_cast<std::size_t>(x)] * electrons * gain[x]);
        const float z = table(static_cast<std::uint32_t>(row() >> 32));
        // Cornish-Fisher: a Poisson's third moment is its mean.
        const float variance = mean + read_variance;
        const float skew = variance > 0 ? mean / (6 * variance) * (z * z - 1) : 0;
        const float e = std::min(mean + std::sqrt(variance) * z + skew, full_well);
        out[x] = static_cast<std::uint16_t>(
            std::clamp(std::floor(e * codes_per_e + 0.5F), 0.0F, largest_code));
      }
    }
  });
  return codes;
}

}  // namespace cousin
