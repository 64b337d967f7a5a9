#include "sim/sensors/noise_grain.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "sim/sensors/fast_normal.h"

namespace cousin {

Image<float> noise_grain(int width, int height, double grain_px, const Rng& rng) {
  const int radius = std::max(0, static_cast<int>(std::lround((grain_px - 1) / 2)));
  const int tall = height + 2 * radius, wide = width + 2 * radius;
  const NormalTable& table = normal_table();
  // White rows summed along the row, then columns of those.
  Image<float> across(width, tall);
  tbb::parallel_for(tbb::blocked_range<int>(0, tall, 16), [&](const auto& range) {
    std::vector<float> white(static_cast<std::size_t>(wide));
    for (int y = range.begin(); y < range.end(); ++y) {
      Rng row = rng.fork(static_cast<std::uint64_t>(y));
      for (std::size_t x = 0; x < white.size(); x += 2) {
        const std::uint64_t bits = row();
        white[x] = table(static_cast<std::uint32_t>(bits >> 32));
        if (x + 1 < white.size()) white[x + 1] = table(static_cast<std::uint32_t>(bits));
      }
      float* out = across.row(y).data();
      std::fill(out, out + width, 0.0F);
      for (int k = 0; k <= 2 * radius; ++k) {
        const float* from = white.data() + k;
        for (int x = 0; x < width; ++x) out[x] += from[x];
      }
    }
  });
  const float scale = 1 / static_cast<float>(2 * radius + 1);
  Image<float> result(width, height);
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 16), [&](const auto& range) {
    for (int y = range.begin(); y < range.end(); ++y) {
      float* out = result.row(y).data();
      std::fill(out, out + width, 0.0F);
      for (int k = 0; k <= 2 * radius; ++k) {
        const float* from = across.row(y + k).data();
        for (int x = 0; x < width; ++x) out[x] += from[x];
      }
      for (int x = 0; x < width; ++x) out[x] *= scale;
    }
  });
  return result;
}

float normal_share(float x) {
  const float a = std::abs(x), t = 1 / (1 + 0.2316419F * a);
  const float tail =
      0.39894228F * std::exp(-0.5F * a * a) * t *
      (0.31938153F + t * (-0.35656378F + t * (1.7814779F + t * (-1.8212559F + t * 1.3302744F))));
  return x >= 0 ? 1 - tail : tail;
}

}  // namespace cousin
