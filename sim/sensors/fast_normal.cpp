#include "sim/sensors/fast_normal.h"

#include <cmath>
#include <numbers>

namespace cousin {

double normal_quantile(double probability) {
  // The upper half mirrors the lower, where erfc keeps its relative precision.
  if (probability > 0.5) return -normal_quantile(1 - probability);
  if (probability == 0.5) return 0;
  // Newton on log P, which is concave: from a start left of the root it converges monotonically.
  const double log_target = std::log(probability);
  double x = -std::sqrt(-2 * log_target);
  for (int step = 0; step < 60; ++step) {
    const double cdf = 0.5 * std::erfc(-x / std::numbers::sqrt2);
    const double pdf = std::exp(-0.5 * x * x) / std::sqrt(2 * std::numbers::pi);
    const double change = (log_target - std::log(cdf)) * cdf / pdf;
    x += change;
    if (std::abs(change) < 1e-15 * (1 + std::abs(x))) break;
  }
  return x;
}

NormalTable::NormalTable() {
  for (std::uint32_t bin = 1; bin < kBins; ++bin) {
    edges_[bin] = static_cast<float>(normal_quantile(static_cast<double>(bin) / kBins));
  }
  // Second moment of the piecewise uniform density, plus the exact one of the two tails.
  double inner = 0;
  for (std::uint32_t bin = 1; bin + 1 < kBins; ++bin) {
    const double a = edges_[bin];
    const double b = edges_[bin + 1];
    inner += (a * a + a * b + b * b) / (3.0 * kBins);
  }
  const double q = edges_[1];
  const double pdf = std::exp(-0.5 * q * q) / std::sqrt(2 * std::numbers::pi);
  const double tails = 2 * (1.0 / kBins - q * pdf);  // E[x^2; x < q] = P(x < q) - q pdf(q)
  const float scale = static_cast<float>(std::sqrt((1 - tails) / inner));
  for (float& edge : edges_) edge *= scale;
}

float NormalTable::tail(std::uint32_t bits) const {
  return static_cast<float>(normal_quantile((static_cast<double>(bits) + 0.5) * 0x1.0p-32));
}

const NormalTable& normal_table() {
  static const NormalTable table;
  return table;
}

}  // namespace cousin
