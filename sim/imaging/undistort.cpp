#include "sim/imaging/undistort.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

namespace cousin {
namespace {

constexpr int kMostSide_px = 65535;
constexpr std::int64_t kMostPixels = std::int64_t{1} << 28;

/// Up to four samples about a coordinate along one axis and their weights.
struct Taps {
  std::array<int, 4> at{};
  std::array<double, 4> weight{};
  int count = 0;
};

/// `x` lies within [0, size - 1]. A sample of weight zero is left out, so that what it holds (NaN)
/// does not count; beyond the border the last sample is repeated.
Taps taps(double x, int size, UndistortConfig::Interpolation interpolation) {
  const int i = std::min(static_cast<int>(x), std::max(size - 2, 0));
  const double t = x - i;
  Taps result;
  const auto add = [&](int at, double weight) {
    if (weight == 0) return;
    const auto k = static_cast<std::size_t>(result.count++);
    result.at[k] = std::clamp(at, 0, size - 1);
    result.weight[k] = weight;
  };
  if (interpolation == UndistortConfig::Interpolation::nearest) {
    add(t < 0.5 ? i : i + 1, 1);
  } else if (interpolation == UndistortConfig::Interpolation::bilinear) {
    add(i, 1 - t);
    add(i + 1, t);
  } else {
    add(i - 1, ((-0.5 * t + 1) * t - 0.5) * t);
    add(i, (1.5 * t - 2.5) * t * t + 1);
    add(i + 1, ((-1.5 * t + 2) * t + 0.5) * t);
    add(i + 2, (0.5 * t - 0.5) * t * t);
  }
  return result;
}

/// Weighted sum of the samples that `channel` reads.
template <class Pixel, class Channel>
double sum_of(const Image<Pixel>& image, const Taps& x, const Taps& y, const Channel& channel) {
  double sum = 0;
  for (int j = 0; j < y.count; ++j) {
    double row = 0;
    for (int i = 0; i < x.count; ++i) {
      row += x.weight[static_cast<std::size_t>(i)] *
             channel(image(x.at[static_cast<std::size_t>(i)], y.at[static_cast<std::size_t>(j)]));
    }
    sum += y.weight[static_cast<std::size_t>(j)] * row;
  }
  return sum;
}

std::uint8_t code(double value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}
Rgb8 sample(const Image<Rgb8>& image, const Taps& x, const Taps& y) {
  return {code(sum_of(image, x, y, [](const Rgb8& c) { return c.r; })),
          code(sum_of(image, x, y, [](const Rgb8& c) { return c.g; })),
          code(sum_of(image, x, y, [](const Rgb8& c) { return c.b; }))};
}
std::uint8_t sample(const Image<std::uint8_t>& image, const Taps& x, const Taps& y) {
  return code(sum_of(image, x, y, [](std::uint8_t v) { return v; }));
}
float sample(const Image<float>& image, const Taps& x, const Taps& y) {
  return static_cast<float>(sum_of(image, x, y, [](float v) { return v; }));
}

std::uint16_t sample(const Image<std::uint16_t>& image, const Taps& x, const Taps& y) {
  return image(x.at[0], y.at[0]);
}

template <class Pixel>
Undistorted<Pixel> undistort_any(const Image<Pixel>& image, const Camera& lens,
                                 const UndistortConfig& config, const Pixel& border) {
  validate(lens);
  if (image.width() != lens.width_px || image.height() != lens.height_px) {
    throw std::invalid_argument("undistort: the image is " + std::to_string(image.width()) + " x " +
                                std::to_string(image.height()) + " px, its lens " +
                                std::to_string(lens.width_px) + " x " +
                                std::to_string(lens.height_px));
  }
  const Camera pinhole = undistorted_camera(lens, config);
  Undistorted<Pixel> result{pinhole, Image<Pixel>(pinhole.width_px, pinhole.height_px, border),
                            Image<std::uint8_t>(pinhole.width_px, pinhole.height_px, 0)};
  const Lens from(lens);
  tbb::parallel_for(0, pinhole.height_px, [&](int y) {
    for (int x = 0; x < pinhole.width_px; ++x) {
      const Eigen::Vector3d ray((x - pinhole.cx_px) / pinhole.fx_px,
                                (y - pinhole.cy_px) / pinhole.fy_px, 1);
      const auto at = from.project(ray);
      if (!at || !(at->x() >= 0 && at->x() <= lens.width_px - 1) ||
          !(at->y() >= 0 && at->y() <= lens.height_px - 1)) {
        continue;
      }
      result.image(x, y) = sample(image, taps(at->x(), lens.width_px, config.interpolation),
                                  taps(at->y(), lens.height_px, config.interpolation));
      result.valid(x, y) = 255;
    }
  });
  return result;
}

}  // namespace

void validate(const UndistortConfig& config) {
  const auto side = [](const char* name, int value) {
    if (value < 0 || value > kMostSide_px) {
      throw std::invalid_argument("undistort: " + std::string(name) + " = " +
                                  std::to_string(value) + " is not within 0.." +
                                  std::to_string(kMostSide_px));
    }
  };
  side("width_px", config.width_px);
  side("height_px", config.height_px);
  if (static_cast<std::int64_t>(config.width_px) * config.height_px > kMostPixels) {
    throw std::invalid_argument("undistort: " + std::to_string(config.width_px) + " x " +
                                std::to_string(config.height_px) + " is above 2^28 pixels");
  }
  if (!(config.focal_px >= 0) || !std::isfinite(config.focal_px)) {
    throw std::invalid_argument("undistort: focal_px = " + std::to_string(config.focal_px) +
                                " is negative or not finite");
  }
  if (config.pinhole.width_px == 0) return;
  validate(config.pinhole);
  if (config.pinhole.model != LensModel::pinhole) {
    throw std::invalid_argument("undistort: pinhole.model = " +
                                std::string(to_string(config.pinhole.model)) + " is not pinhole");
  }
}

Camera undistorted_camera(const Camera& lens, const UndistortConfig& config) {
  validate(config);
  if (config.pinhole.width_px > 0) return config.pinhole;
  Camera pinhole = resized(lens, config.width_px > 0 ? config.width_px : lens.width_px,
                           config.height_px > 0 ? config.height_px : lens.height_px);
  pinhole.model = LensModel::pinhole;
  pinhole.distortion = {};
  pinhole.spline = {};
  if (config.focal_px > 0) pinhole.fx_px = pinhole.fy_px = config.focal_px;
  return pinhole;
}

Undistorted<Rgb8> undistort(const Image<Rgb8>& image, const Camera& lens,
                            const UndistortConfig& config, Rgb8 border) {
  return undistort_any(image, lens, config, border);
}
Undistorted<std::uint8_t> undistort(const Image<std::uint8_t>& image, const Camera& lens,
                                    const UndistortConfig& config, std::uint8_t border) {
  return undistort_any(image, lens, config, border);
}
Undistorted<float> undistort(const Image<float>& image, const Camera& lens,
                             const UndistortConfig& config, float border) {
  return undistort_any(image, lens, config, border);
}
Undistorted<std::uint16_t> undistort(const Image<std::uint16_t>& image, const Camera& lens,
                                     const UndistortConfig& config, std::uint16_t border) {
  if (config.interpolation != UndistortConfig::Interpolation::nearest)
    throw std::invalid_argument("undistort: 16-bit values do not mix; interpolation = nearest");
  return undistort_any(image, lens, config, border);
}

}  // namespace cousin
