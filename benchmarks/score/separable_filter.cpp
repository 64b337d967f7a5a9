#include "benchmarks/score/separable_filter.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <span>

namespace cousin {
namespace {

constexpr std::size_t kTogether = 16;  ///< sums that stay in registers

/// to[x] = sum over k of taps[k] * from(k)[x], in the order of k.
template <class From>
void weighted_sums(const FilterTaps& taps, const From& from, std::span<double> to) {
  std::size_t x = 0;
  for (; x + kTogether <= to.size(); x += kTogether) {
    double sum[kTogether] = {};
    for (std::size_t k = 0; k < taps.size(); ++k) {
      const double* const values = from(k) + x;
      for (std::size_t i = 0; i < kTogether; ++i) sum[i] += taps[k] * values[i];
    }
    std::copy(sum, sum + kTogether, to.begin() + static_cast<std::ptrdiff_t>(x));
  }
  for (; x < to.size(); ++x) {
    double sum = 0;
    for (std::size_t k = 0; k < taps.size(); ++k) sum += taps[k] * from(k)[x];
    to[x] = sum;
  }
}

}  // namespace

Image<double> filtered(const Image<double>& image, const FilterTaps& along_x,
                       const FilterTaps& along_y, FilterBorder border) {
  const auto width = static_cast<std::size_t>(image.width());
  const int height = image.height();
  Image<double> rows(image.width(), height);
  Image<double> result(image.width(), height);
  if (result.empty()) return result;
  const std::size_t radius_x = along_x.size() / 2;
  tbb::parallel_for(tbb::blocked_range<int>(0, height), [&](const auto& range) {
    std::vector<double> wide(width + 2 * radius_x, 0);  // a row and what is beyond its ends
    const auto inner = wide.begin() + static_cast<std::ptrdiff_t>(radius_x);
    for (int y = range.begin(); y < range.end(); ++y) {
      const auto from = image.row(y);
      std::copy(from.begin(), from.end(), inner);
      if (border == FilterBorder::replicate) {
        std::fill(wide.begin(), inner, from.front());
        std::fill(inner + static_cast<std::ptrdiff_t>(width), wide.end(), from.back());
      }
      weighted_sums(
          along_x, [&](std::size_t k) { return wide.data() + k; }, rows.row(y));
    }
  });
  const int radius_y = static_cast<int>(along_y.size() / 2);
  const std::vector<double> nothing(width, 0);
  tbb::parallel_for(tbb::blocked_range<int>(0, height), [&](const auto& range) {
    std::vector<const double*> from(along_y.size());
    for (int y = range.begin(); y < range.end(); ++y) {
      for (std::size_t k = 0; k < from.size(); ++k) {
        const int at = y + static_cast<int>(k) - radius_y;
        const bool beyond = at < 0 || at >= height;
        from[k] = beyond && border == FilterBorder::zero
                      ? nothing.data()
                      : rows.row(std::clamp(at, 0, height - 1)).data();
      }
      weighted_sums(
          along_y, [&](std::size_t k) { return from[k]; }, result.row(y));
    }
  });
  return result;
}

FilterTaps gaussian_taps(double sigma, int radius) {
  FilterTaps taps;
  double sum = 0;
  for (int k = -radius; k <= radius; ++k) {
    taps.push_back(std::exp(-k * k / (2 * sigma * sigma)));
    sum += taps.back();
  }
  for (double& tap : taps) tap /= sum;
  return taps;
}

}  // namespace cousin
