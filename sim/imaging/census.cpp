#include "sim/imaging/census.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

namespace cousin {
namespace {

/// The image with its border repeated, so that no window leaves it.
template <class Pixel>
Image<Pixel> padded(const Image<Pixel>& image, int x_px, int y_px) {
  Image<Pixel> out(image.width() + 2 * x_px, image.height() + 2 * y_px);
  for (int y = 0; y < out.height(); ++y) {
    const auto from = image.row(std::clamp(y - y_px, 0, image.height() - 1));
    const auto to = out.row(y);
    std::fill_n(to.begin(), x_px, from.front());
    std::copy(from.begin(), from.end(), to.begin() + x_px);
    std::fill(to.end() - x_px, to.end(), from.back());
  }
  return out;
}

template <class Pixel>
Image<std::uint64_t> transform(const Image<Pixel>& image, int width_px, int height_px,
                               double margin) {
  census_pairs(width_px, height_px);
  if (!(margin >= 0)) {
    throw std::invalid_argument("census margin " + std::to_string(margin) + " is negative");
  }
  if (image.empty()) return {};
  const auto least = static_cast<float>(margin);
  const int rx = width_px / 2, ry = height_px / 2;
  const Image<Pixel> wide = padded(image, rx, ry);
  Image<std::uint64_t> codes(image.width(), image.height());
  tbb::parallel_for(tbb::blocked_range<int>(0, image.height(), 16), [&](const auto& rows) {
    for (int y = rows.begin(); y < rows.end(); ++y) {
      std::uint64_t* out = codes.row(y).data();
      int bit = 0;
      for (int dy = -ry; dy <= 0; ++dy) {
        for (int dx = -rx; dx <= (dy < 0 ? rx : -1); ++dx, ++bit) {
          const Pixel* a = wide.row(y + ry + dy).data() + rx + dx;
          const Pixel* b = wide.row(y + ry - dy).data() + rx - dx;
          for (int x = 0; x < image.width(); ++x) {
            const float difference = static_cast<float>(a[x]) - static_cast<float>(b[x]);
            const auto brighter = static_cast<std::uint64_t>(difference > least);
            const auto darker = static_cast<std::uint64_t>(difference < -least);
            out[x] |= (brighter | darker << 1U) << (2 * bit);
          }
        }
      }
    }
  });
  return codes;
}

}  // namespace

int census_pairs(int width_px, int height_px) {
  const bool odd = width_px % 2 == 1 && height_px % 2 == 1;
  if (!odd || width_px < 1 || height_px < 1 || width_px > 65 || height_px > 65 ||
      width_px * height_px < 3 || width_px * height_px > 65) {
    throw std::invalid_argument("census window " + std::to_string(width_px) + " x " +
                                std::to_string(height_px) + " must be odd, of 3 to 65 pixels");
  }
  return (width_px * height_px - 1) / 2;
}

Image<std::uint64_t> census_transform(const Image<float>& image, int width_px, int height_px,
                                      double margin) {
  return transform(image, width_px, height_px, margin);
}

Image<std::uint64_t> census_transform(const Image<std::uint16_t>& image, int width_px,
                                      int height_px, double margin) {
  return transform(image, width_px, height_px, margin);
}

}  // namespace cousin
