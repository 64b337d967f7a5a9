#include "sim/sensors/match_contrast.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/sensors/active_stereo.h"
#include "sim/sensors/depth_model.h"
#include "sim/sensors/fast_normal.h"
#include "sim/sensors/noise_grain.h"

namespace cousin {
namespace {

constexpr int kSignals = 57, kNoises = 29;    // nodes
constexpr float kSteps = 4, kNoiseSteps = 2;  // of the logarithms to base 2

/// Two pixels of a window: their difference, and the sums of their light and of its square, over
/// the mean signal.
struct Pair {
  float difference = 0, light = 0, squares = 0;
};

/// Pairs of a projector's dots, or of a texture, in classes of rising difference.
std::vector<Pair> window_pairs(const ActiveStereoConfig& config, double spread) {
  constexpr int kClasses = 36, kLevels = 12;
  std::vector<Pair> pairs;
  if (!config.has_projector) {
    for (int i = 0; i < kClasses; ++i) {
      const double half = normal_quantile(0.5 + 0.5 * (i + 0.5) / kClasses);
      pairs.push_back({static_cast<float>(std::numbers::sqrt2 * half), 0, 0});
    }
    return pairs;
  }
  const double blur_rad = config.imager.blur_sigma_px / depth_camera(config).fx_px;
  const double cover = spread * dot_cover(config.projector, blur_rad);
  std::vector<float> levels;
  for (int i = 0; i < kLevels; ++i) {
    const double share = config.projector.background;
    levels.push_back(
        static_cast<float>(share + (1 - share) / cover * std::exp(-(i + 0.5) / (kLevels * cover))));
  }
  std::vector<Pair> all;
  for (const float a : levels) {
    for (const float b : levels) all.push_back({std::abs(a - b), a + b, a * a + b * b});
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const Pair& a, const Pair& b) { return a.difference < b.difference; });
  const std::size_t size = all.size() / kClasses;
  for (std::size_t i = 0; i < all.size(); i += size) {
    Pair mean;
    for (std::size_t k = i; k < i + size; ++k) {
      mean.difference += all[k].difference / static_cast<float>(size);
      mean.light += all[k].light / static_cast<float>(size);
      mean.squares += all[k].squares / static_cast<float>(size);
    }
    pairs.push_back(mean);
  }
  return pairs;
}

/// What the imager's blur leaves of the contrast of grains as small as a pixel.
double blurred_speckle(const ActiveStereoConfig& config) {
  const double sigma = config.imager.blur_sigma_px;
  const double left = 1 / std::max(1.0, 4 * std::numbers::pi * sigma * sigma);
  return config.infrared.speckle_contrast * std::sqrt(left);
}

}  // namespace

MatchContrast::MatchContrast(const ActiveStereoConfig& config, const PatternLight& light,
                             double dots, double spread)
    : still_e2_(static_cast<float>(light.still_e2)) {
  const std::vector<Pair> pairs = window_pairs(config, spread);
  const auto margin = static_cast<float>(light.margin_e);
  const auto speckle = static_cast<float>(std::pow(blurred_speckle(config), 2));
  first_signal_ = std::log2(std::max(margin, 1e-3F)) - 7;
  first_noise_ = std::log2(std::max(still_e2_, 1e-6F));
  for (int j = 0; j < kNoises; ++j) {
    const float base = 2 * std::exp2(first_noise_ + static_cast<float>(j) / kNoiseSteps);
    for (int i = 0; i < kSignals; ++i) {
      const float signal = std::exp2(first_signal_ + static_cast<float>(i) / kSteps);
      float own = 0, set = 0;
      for (const Pair& pair : pairs) {
        const float root = std::sqrt(base + static_cast<float>(dots) * pair.light * signal +
                                     speckle * pair.squares * signal * signal);
        const float brighter = normal_share((pair.difference * signal - margin) / root);
        const float darker = normal_share((-pair.difference * signal - margin) / root);
        own += brighter * (1 - brighter) + darker * (1 - darker);
        set += 0.5F * (brighter + darker);
      }
      const auto n = static_cast<float>(pairs.size());
      set /= n;
      const float ratio = own / n / std::max(2 * set * (1 - set), 1e-20F);
      table_.push_back(-std::log2(std::clamp(ratio, 1e-4F, 1.0F)));
    }
  }
}

float MatchContrast::operator()(float signal_e, float ambient_e) const {
  if (!(signal_e > 0)) return 0;
  const auto place = [](float value, float first, float steps, int nodes) {
    return std::clamp((std::log2(value) - first) * steps, 0.0F, static_cast<float>(nodes) - 1.001F);
  };
  const float u = place(signal_e, first_signal_, kSteps, kSignals);
  const float v = place(ambient_e + still_e2_, first_noise_, kNoiseSteps, kNoises);
  const int i = static_cast<int>(u), j = static_cast<int>(v);
  const float s = u - static_cast<float>(i), t = v - static_cast<float>(j);
  const float* row = table_.data() + j * kSignals + i;
  return (row[0] * (1 - s) + row[1] * s) * (1 - t) +
         (row[kSignals] * (1 - s) + row[kSignals + 1] * s) * t;
}

}  // namespace cousin
