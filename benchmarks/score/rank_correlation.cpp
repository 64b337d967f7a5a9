#include "benchmarks/score/rank_correlation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include "benchmarks/score/order_statistics.h"

namespace cousin {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Ranks from 0; equal values share the mean of theirs.
std::vector<double> ranks(const std::vector<double>& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t i, std::size_t j) { return values[i] < values[j]; });
  std::vector<double> result(values.size());
  for (std::size_t i = 0; i < order.size();) {
    std::size_t end = i;
    while (end < order.size() && values[order[end]] == values[order[i]]) ++end;
    for (std::size_t k = i; k < end; ++k) result[order[k]] = 0.5 * static_cast<double>(i + end - 1);
    i = end;
  }
  return result;
}

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  const double mean_a = mean(a), mean_b = mean(b);
  double aa = 0, bb = 0, ab = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    aa += (a[i] - mean_a) * (a[i] - mean_a);
    bb += (b[i] - mean_b) * (b[i] - mean_b);
    ab += (a[i] - mean_a) * (b[i] - mean_b);
  }
  return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : kNone;
}

}  // namespace

WithInterval rank_correlation(std::span<const double> a, std::span<const double> b, Rng rng,
                              const BootstrapConfig& config) {
  if (a.size() != b.size()) {
    throw std::invalid_argument("rank correlation: " + std::to_string(a.size()) + " and " +
                                std::to_string(b.size()) + " values are not pairs");
  }
  const auto is_nan = [](double v) { return std::isnan(v); };
  if (std::any_of(a.begin(), a.end(), is_nan) || std::any_of(b.begin(), b.end(), is_nan))
    throw std::invalid_argument("rank correlation: a value is NaN");
  WithInterval result;
  if (a.size() < 3) return result;
  result.value = correlation(ranks({a.begin(), a.end()}), ranks({b.begin(), b.end()}));
  std::vector<double> drawn, x(a.size()), y(a.size());
  for (int r = 0; r < config.resamples; ++r) {
    Rng own = rng.fork(static_cast<std::uint64_t>(r));
    for (std::size_t i = 0; i < a.size(); ++i) {
      const auto from = std::min(
          a.size() - 1, static_cast<std::size_t>(uniform(own) * static_cast<double>(a.size())));
      x[i] = a[from];
      y[i] = b[from];
    }
    const double value = correlation(ranks(x), ranks(y));
    if (std::isfinite(value)) drawn.push_back(value);
  }
  if (!drawn.empty() && std::isfinite(result.value)) {
    result.low = quantile(drawn, 0.025);
    result.high = quantile(drawn, 0.975);
  }
  return result;
}

}  // namespace cousin
