#include "benchmarks/tools/fit_sensor/rounding.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "benchmarks/score/distributions.h"

namespace cousin {

double rounded_variance(double sigma, double first, double second) {
  if (!(first > 0)) std::swap(first, second);
  if (!(first > 0) || !(sigma > 0)) return sigma * sigma;
  if (sigma > 3 * std::max(first, second))
    return sigma * sigma + (first * first + second * second) / 12;
  constexpr int kPlaces = 1024;
  double sum = 0;
  for (int i = 0; i < kPlaces; ++i) {
    const double u = i * (std::numbers::phi - 1), v = i * (std::numbers::sqrt2 - 1);
    const double at = (u - std::floor(u)) * first, offset = (v - std::floor(v)) * second;
    const auto from = static_cast<long>(std::floor((at - 6 * sigma) / first + 0.5));
    const auto to = static_cast<long>(std::floor((at + 6 * sigma) / first + 0.5));
    double mean = 0, squares = 0, below = normal_cdf(((from - 0.5) * first - at) / sigma);
    for (long k = from; k <= to; ++k) {
      const double above = normal_cdf(((k + 0.5) * first - at) / sigma);
      double value = k * first;
      if (second > 0) value = std::round((value + offset) / second) * second - offset;
      mean += (above - below) * (value - at);
      squares += (above - below) * (value - at) * (value - at);
      below = above;
    }
    sum += std::max(0.0, squares - mean * mean);
  }
  return sum / kPlaces;
}

double unrounded_sigma(double variance, double first, double second) {
  double low = 0, high = std::sqrt(variance);
  for (int k = 0; k < 30; ++k) {
    const double middle = 0.5 * (low + high);
    (rounded_variance(middle, first, second) > variance ? high : low) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace cousin
