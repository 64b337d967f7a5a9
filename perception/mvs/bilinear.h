#pragma once

#include <array>
#include <cstddef>

#include "sim/types/image.h"

namespace cousin {

/// Many bilinear look-ups at once, in three loops: where, the four neighbours, and the mixture. The
/// outer two are vectorised; one loop for all would not be, since compilers doubt gathers.
template <std::size_t kMost>
struct BilinearLookUp {
  using Floats = std::array<float, kMost>;
  alignas(32) Floats x, y;      ///< in: where
  alignas(32) Floats inside;    ///< 1, or 0 where (x, y) is outside the image or NaN
  alignas(32) Floats value;     ///< 0 outside
  alignas(32) Floats d_x, d_y;  ///< slope of the value; only with slopes

  template <bool kSlopes>
  void run(const Image<float>& image, std::size_t count) {
    const int stride = image.width();
    const float last_x = static_cast<float>(image.width()) - 1.001F;
    const float last_y = static_cast<float>(image.height()) - 1.001F;
    for (std::size_t i = 0; i < count; ++i) {
      float u = x[i] > 0 ? x[i] : 0.0F, v = y[i] > 0 ? y[i] : 0.0F;  // NaN becomes zero
      u = u < last_x ? u : last_x;
      v = v < last_y ? v : last_y;
      inside[i] = (u == x[i]) & (v == y[i]) ? 1.0F : 0.0F;
      const int ix = static_cast<int>(u), iy = static_cast<int>(v);
      across_[i] = u - static_cast<float>(ix);
      down_[i] = v - static_cast<float>(iy);
      at_[i] = iy * stride + ix;
    }
    const float* pixels = image.data();
    for (std::size_t i = 0; i < count; ++i) {
      const float* p = pixels + at_[i];
      p00_[i] = p[0];
      p01_[i] = p[1];
      p10_[i] = p[stride];
      p11_[i] = p[stride + 1];
    }
    for (std::size_t i = 0; i < count; ++i) {
      const float top_step = p01_[i] - p00_[i], low_step = p11_[i] - p10_[i];
      const float top = p00_[i] + across_[i] * top_step, low = p10_[i] + across_[i] * low_step;
      value[i] = inside[i] * (top + down_[i] * (low - top));
      if constexpr (kSlopes) {
        d_x[i] = inside[i] * (top_step + down_[i] * (low_step - top_step));
        d_y[i] = inside[i] * (low - top);
      }
    }
  }

 private:
  alignas(32) Floats across_, down_, p00_, p01_, p10_, p11_;
  alignas(32) std::array<int, kMost> at_;
};

}  // namespace cousin
