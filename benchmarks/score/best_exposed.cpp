#include "benchmarks/score/best_exposed.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "sim/imaging/color.h"

namespace cousin {
namespace {

constexpr double kMost = 2.0794415;  // ln 8
constexpr int kSearched = 20'000;    // pixels that the factor is found by, about
constexpr int kTried = 16;           // steps between factors that are tried first
constexpr int kRounds = 25;          // of the golden section: 0.5 becomes 3e-6

struct Pair {
  float light, encoded;  ///< of the image, of the photograph
};

double squares(const std::vector<Pair>& pairs, double log_factor) {
  const auto factor = static_cast<float>(std::exp(log_factor));
  double sum = 0;
  for (const Pair& p : pairs) {
    const double off = static_cast<double>(srgb_from_linear(factor * p.light)) - p.encoded;
    sum += off * off;
  }
  return sum;
}

/// The best of evenly spread factors, then a golden section about it: pixels that clip may make
/// more than one least value.
double best_log_factor(const std::vector<Pair>& pairs) {
  double best = -kMost, least = squares(pairs, best);
  for (int i = 1; i <= kTried; ++i) {
    const double at = -kMost + 2 * kMost * i / kTried, there = squares(pairs, at);
    if (there < least) {
      least = there;
      best = at;
    }
  }
  const double golden = 0.5 * (std::sqrt(5.0) - 1), step = 2 * kMost / kTried;
  double low = std::max(-kMost, best - step), high = std::min(kMost, best + step);
  double left = high - golden * (high - low), right = low + golden * (high - low);
  double at_left = squares(pairs, left), at_right = squares(pairs, right);
  for (int round = 0; round < kRounds; ++round) {
    if (at_left < at_right) {
      high = right;
      right = left;
      at_right = at_left;
      at_left = squares(pairs, left = high - golden * (high - low));
    } else {
      low = left;
      left = right;
      at_left = at_right;
      at_right = squares(pairs, right = low + golden * (high - low));
    }
  }
  return 0.5 * (low + high);
}

}  // namespace

FidelityPlanes best_exposed(const FidelityPlanes& image, const FidelityPlanes& photograph,
                            const Image<std::uint8_t>& mask) {
  const auto counts = [&](std::size_t i) { return mask.empty() || mask.data()[i] != 0; };
  const std::size_t pixels = photograph[0].size();
  std::size_t shown = 0;
  for (std::size_t i = 0; i < pixels; ++i) shown += counts(i) ? 1 : 0;
  const std::size_t every = std::max<std::size_t>(1, shown / kSearched);
  std::vector<Pair> pairs;
  for (std::size_t c = 0; c < 3; ++c) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
      if (!counts(i) || count++ % every != 0) continue;
      const float value = std::clamp(image[c].data()[i], 0.0F, 1.0F);
      pairs.push_back({linear_from_srgb(value), photograph[c].data()[i]});
    }
  }
  if (pairs.empty()) return image;
  const auto factor = static_cast<float>(std::exp(best_log_factor(pairs)));
  FidelityPlanes exposed = image;
  for (Image<float>& channel : exposed) {
    for (std::size_t i = 0; i < channel.size(); ++i) {
      float& value = channel.data()[i];
      value = srgb_from_linear(factor * linear_from_srgb(std::clamp(value, 0.0F, 1.0F)));
    }
  }
  return exposed;
}

}  // namespace cousin
