#include "benchmarks/score/image_fidelity.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <string>

#include "benchmarks/score/separable_filter.h"

namespace cousin {
namespace {

void require_sizes(const FidelityPlanes& image, const FidelityPlanes& photograph,
                   const Image<std::uint8_t>& mask, const char* what) {
  const Image<float>& like = photograph[0];
  const auto require = [&](int width, int height, const char* name) {
    if (width == like.width() && height == like.height()) return;
    throw std::invalid_argument(std::string(what) + ": " + name + " is " + std::to_string(width) +
                                " x " + std::to_string(height) + ", the photograph's red is " +
                                std::to_string(like.width()) + " x " +
                                std::to_string(like.height()));
  };
  for (const Image<float>& channel : photograph)
    require(channel.width(), channel.height(), "a channel of it");
  for (const Image<float>& channel : image) require(channel.width(), channel.height(), "the image");
  if (!mask.empty()) require(mask.width(), mask.height(), "the mask");
}

/// Keeps NaN.
double clamped(float value) {
  const double v = static_cast<double>(value);
  return v < 0 ? 0 : v > 1 ? 1 : v;
}

/// Mean of value(pixel) over the pixels that count; NaN if there is none.
double mean_over(const Image<float>& like, const Image<std::uint8_t>& mask,
                 const std::function<double(std::size_t)>& value) {
  double sum = 0;
  long long count = 0;
  for (std::size_t i = 0; i < like.size(); ++i) {
    if (!mask.empty() && mask.data()[i] == 0) continue;
    sum += value(i);
    ++count;
  }
  return count > 0 ? sum / static_cast<double>(count) : kNaN;
}

Image<double> product(const Image<double>& a, const Image<double>& b) {
  Image<double> result(a.width(), a.height());
  for (std::size_t i = 0; i < a.size(); ++i) result.data()[i] = a.data()[i] * b.data()[i];
  return result;
}

Image<double> as_double(const Image<float>& image) {
  Image<double> result(image.width(), image.height());
  for (std::size_t i = 0; i < image.size(); ++i) result.data()[i] = clamped(image.data()[i]);
  return result;
}

Image<double> similarity_map(const Image<float>& image, const Image<float>& photograph) {
  constexpr double kC1 = 0.01 * 0.01, kC2 = 0.03 * 0.03;
  const FilterTaps taps = gaussian_taps(1.5, 5);
  const auto windowed = [&](const Image<double>& of) {
    return filtered(of, taps, taps, FilterBorder::zero);
  };
  const Image<double> a = as_double(image), b = as_double(photograph);
  const Image<double> mean_a = windowed(a), mean_b = windowed(b);
  const Image<double> aa = windowed(product(a, a)), bb = windowed(product(b, b));
  const Image<double> ab = windowed(product(a, b));
  Image<double> result(image.width(), image.height());
  for (std::size_t i = 0; i < result.size(); ++i) {
    const double ma = mean_a.data()[i], mb = mean_b.data()[i];
    const double variances = aa.data()[i] - ma * ma + bb.data()[i] - mb * mb;
    const double covariance = ab.data()[i] - ma * mb;
    result.data()[i] = (2 * ma * mb + kC1) * (2 * covariance + kC2) /
                       ((ma * ma + mb * mb + kC1) * (variances + kC2));
  }
  return result;
}

}  // namespace

FidelityPlanes fidelity_planes(const Image<Rgb8>& image) {
  FidelityPlanes planes;
  for (Image<float>& channel : planes) channel = Image<float>(image.width(), image.height());
  for (std::size_t i = 0; i < image.size(); ++i) {
    const Rgb8 code = image.data()[i];
    planes[0].data()[i] = static_cast<float>(code.r) / 255;
    planes[1].data()[i] = static_cast<float>(code.g) / 255;
    planes[2].data()[i] = static_cast<float>(code.b) / 255;
  }
  return planes;
}

Image<Rgb8> rgb_of(const FidelityPlanes& planes) {
  const auto& [red, green, blue] = planes;
  const auto code = [](float value) {
    return static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.0F, 1.0F)));
  };
  Image<Rgb8> image(red.width(), red.height());
  for (std::size_t i = 0; i < image.size(); ++i)
    image.data()[i] = {code(red.data()[i]), code(green.data()[i]), code(blue.data()[i])};
  return image;
}

Image<std::uint8_t> counted_pixels(const Image<float>& weight) {
  Image<std::uint8_t> mask(weight.width(), weight.height());
  for (std::size_t i = 0; i < mask.size(); ++i) mask.data()[i] = weight.data()[i] >= 0.999F;
  return mask;
}

FidelityPlanes where_counted(FidelityPlanes image, const FidelityPlanes& photograph,
                             const Image<std::uint8_t>& counted) {
  require_sizes(image, photograph, counted, "where_counted");
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < counted.size(); ++i) {
      if (counted.data()[i] == 0) image[c].data()[i] = photograph[c].data()[i];
    }
  }
  return image;
}

double psnr_db(const FidelityPlanes& image, const FidelityPlanes& photograph,
               const Image<std::uint8_t>& mask) {
  require_sizes(image, photograph, mask, "psnr_db");
  const double mean_square = mean_over(photograph[0], mask, [&](std::size_t i) {
    double sum = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const double difference = clamped(image[c].data()[i]) - clamped(photograph[c].data()[i]);
      sum += difference * difference / 3;
    }
    return sum;
  });
  return -10 * std::log10(mean_square);
}

double ssim(const FidelityPlanes& image, const FidelityPlanes& photograph,
            const Image<std::uint8_t>& mask) {
  require_sizes(image, photograph, mask, "ssim");
  double sum = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const Image<double> similarity = similarity_map(image[c], photograph[c]);
    sum += mean_over(photograph[0], mask, [&](std::size_t i) { return similarity.data()[i]; });
  }
  return sum / 3;
}

double flip(const FidelityPlanes& image, const FidelityPlanes& photograph,
            const Image<std::uint8_t>& mask, double pixels_per_degree) {
  require_sizes(image, photograph, mask, "flip");
  const Image<float> map = flip_map(image, photograph, pixels_per_degree);
  return mean_over(map, mask, [&](std::size_t i) { return static_cast<double>(map.data()[i]); });
}

ImageFidelity score_fidelity(const FidelityPlanes& image, const FidelityPlanes& photograph,
                             const Image<std::uint8_t>& mask, double pixels_per_degree) {
  ImageFidelity score;
  score.psnr_db = psnr_db(image, photograph, mask);
  score.ssim = ssim(image, photograph, mask);
  score.flip = flip(image, photograph, mask, pixels_per_degree);
  score.pixels = static_cast<long long>(
      mask.empty() ? photograph[0].size()
                   : mask.size() - static_cast<std::size_t>(
                                       std::count(mask.begin(), mask.end(), std::uint8_t{0})));
  return score;
}

}  // namespace cousin
