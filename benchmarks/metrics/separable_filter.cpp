#include "benchmarks/metrics/separable_filter.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace cousin {

Image<double> filtered(const Image<double>& image, const FilterTaps& along_x,
                       const FilterTaps& along_y, FilterBorder border) {
  const int width = image.width();
  const int height = image.height();
  Image<double> rows(width, height);
  Image<double> result(width, height);
  const auto radius_of = [](const FilterTaps& taps) { return static_cast<int>(taps.size() / 2); };
  tbb::parallel_for(0, height, [&](int y) {
    const int radius = radius_of(along_x);
    const auto from = image.row(y);
    const auto to = rows.row(y);
    for (int x = 0; x < width; ++x) {
      double sum = 0;
      for (int k = -radius; k <= radius; ++k) {
        const int at = x + k;
        if (border == FilterBorder::zero && (at < 0 || at >= width)) continue;
        sum += along_x[static_cast<std::size_t>(k + radius)] *
               from[static_cast<std::size_t>(std::clamp(at, 0, width - 1))];
      }
      to[static_cast<std::size_t>(x)] = sum;
    }
  });
  tbb::parallel_for(0, height, [&](int y) {
    const int radius = radius_of(along_y);
    const auto to = result.row(y);
    for (int k = -radius; k <= radius; ++k) {
      const int at = y + k;
      if (border == FilterBorder::zero && (at < 0 || at >= height)) continue;
      const double tap = along_y[static_cast<std::size_t>(k + radius)];
      const auto from = rows.row(std::clamp(at, 0, height - 1));
      for (std::size_t x = 0; x < to.size(); ++x) to[x] += tap * from[x];
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
