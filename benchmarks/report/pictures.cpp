#include "benchmarks/report/pictures.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "benchmarks/score/order_statistics.h"

namespace cousin {
namespace {

/// Coefficients of the author's own approximation to the map.
Rgb8 turbo(double t) {
  const auto code = [&](double c0, double c1, double c2, double c3, double c4, double c5) {
    const double v = c0 + t * (c1 + t * (c2 + t * (c3 + t * (c4 + t * c5))));
    return static_cast<std::uint8_t>(std::lround(255 * std::clamp(v, 0.0, 1.0)));
  };
  return {code(0.13572138, 4.61539260, -42.66032258, 132.13108234, -152.94239396, 59.28637943),
          code(0.09140261, 2.19418839, 4.84296658, -14.18503333, 4.27729857, 2.82956604),
          code(0.10667330, 12.64194608, -60.58204836, 110.36276771, -89.90310912, 27.34824973)};
}

}  // namespace

Image<Rgb8> scaled_image(const Image<Rgb8>& image, int width, int height) {
  Image<Rgb8> scaled(width, height);
  const double sx = static_cast<double>(image.width()) / width,
               sy = static_cast<double>(image.height()) / height;
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      double sum[3] = {0, 0, 0}, weight = 0;
      const int first_x = static_cast<int>(x * sx),
                last_x = std::min(image.width() - 1, static_cast<int>((x + 1) * sx));
      const int first_y = static_cast<int>(y * sy),
                last_y = std::min(image.height() - 1, static_cast<int>((y + 1) * sy));
      for (int v = first_y; v <= last_y; ++v) {
        const double wy = std::min(v + 1.0, (y + 1) * sy) - std::max<double>(v, y * sy);
        for (int u = first_x; u <= last_x; ++u) {
          const double w = wy * (std::min(u + 1.0, (x + 1) * sx) - std::max<double>(u, x * sx));
          const Rgb8 c = image(u, v);
          sum[0] += w * c.r;
          sum[1] += w * c.g;
          sum[2] += w * c.b;
          weight += w;
        }
      }
      const auto code = [&](int i) {
        return static_cast<std::uint8_t>(std::lround(sum[i] / weight));
      };
      scaled(x, y) = {code(0), code(1), code(2)};
    }
  });
  return scaled;
}

Image<Rgb8> shrunk(const Image<Rgb8>& image, int most_px) {
  const int side = std::max(image.width(), image.height());
  if (side <= most_px) return image;
  const auto to = [&](int px) {
    return std::max(1, static_cast<int>(std::lround(static_cast<double>(px) * most_px / side)));
  };
  return scaled_image(image, to(image.width()), to(image.height()));
}

Image<Rgb8> cropped(const Image<Rgb8>& image, int x0, int y0, int width, int height) {
  const int left = std::clamp(x0, 0, image.width()), top = std::clamp(y0, 0, image.height());
  const int right = std::clamp(x0 + width, left, image.width());
  const int bottom = std::clamp(y0 + height, top, image.height());
  Image<Rgb8> part(right - left, bottom - top);
  for (int y = 0; y < part.height(); ++y) {
    for (int x = 0; x < part.width(); ++x) part(x, y) = image(left + x, top + y);
  }
  return part;
}

Image<Rgb8> side_by_side(const std::vector<Image<Rgb8>>& images, int gap_px) {
  int width = -gap_px, height = 0;
  for (const Image<Rgb8>& image : images) {
    width += image.width() + gap_px;
    height = std::max(height, image.height());
  }
  Image<Rgb8> row(std::max(width, 0), height, {255, 255, 255});
  int left = 0;
  for (const Image<Rgb8>& image : images) {
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) row(left + x, y) = image(x, y);
    }
    left += image.width() + gap_px;
  }
  return row;
}

Image<Rgb8> depth_in_color(const Image<float>& depth_m) {
  constexpr Rgb8 kNone = {48, 48, 48};
  std::vector<double> inverse;
  for (const float z : depth_m) {
    if (std::isfinite(z)) inverse.push_back(1.0 / z);
  }
  Image<Rgb8> picture(depth_m.width(), depth_m.height(), kNone);
  if (inverse.empty()) return picture;
  const double low = quantile(inverse, 0.02), high = quantile(inverse, 0.98);
  std::transform(depth_m.begin(), depth_m.end(), picture.begin(), [&](float z) {
    if (!std::isfinite(z)) return kNone;
    const double t = std::clamp((1.0 / z - low) / std::max(high - low, 1e-12), 0.0, 1.0);
    return turbo(0.06 + 0.88 * t);  // both ends of the map are too dark beside "none"
  });
  return picture;
}

}  // namespace cousin
