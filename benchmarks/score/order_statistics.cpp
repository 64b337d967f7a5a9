#include "benchmarks/score/order_statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cousin {

double mean(std::span<const double> values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());  // 0 / 0 is the NaN promised
}

double rms(std::span<const double> values) {
  double sum = 0;
  for (const double v : values) sum += v * v;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

double quantile(std::vector<double> values, double probability) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const double rank = probability * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), values.begin() + below, values.end());
  const double low = values[static_cast<std::size_t>(below)];
  const double fraction = rank - std::floor(rank);
  if (fraction == 0) return low;
  return low + fraction * (*std::min_element(values.begin() + below + 1, values.end()) - low);
}

}  // namespace cousin
