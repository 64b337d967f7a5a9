#include "benchmarks/suites/light/image_error.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace cousin {
namespace {

constexpr int kTile_px = 16;
constexpr int kResamples = 500;

void require_same_size(const Image<Rgbf>& a, const Image<Rgbf>& b) {
  if (a.empty() || a.width() != b.width() || a.height() != b.height())
    throw std::invalid_argument("image error: images are empty or differ in size");
}

/// Root of the mean of `term(i)` over pixels, and its spread over tiles drawn with replacement.
template <class Term>
WithInterval root_mean(const Image<Rgbf>& image, Rng rng, const Term& term) {
  struct Tile {
    double sum = 0;
    int pixels = 0;
  };
  const int columns = (image.width() + kTile_px - 1) / kTile_px;
  const int rows = (image.height() + kTile_px - 1) / kTile_px;
  std::vector<Tile> tiles(static_cast<std::size_t>(columns * rows));
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      Tile& tile = tiles[static_cast<std::size_t>(y / kTile_px * columns + x / kTile_px)];
      tile.sum += term(x, y);
      ++tile.pixels;
    }
  }
  const auto root_of = [](double sum, double pixels) {
    return std::sqrt(std::max(0.0, sum / pixels));
  };
  double sum = 0;
  for (const Tile& tile : tiles) sum += tile.sum;
  std::vector<double> drawn;
  for (int k = 0; k < kResamples; ++k) {
    double part = 0, pixels = 0;
    for (std::size_t i = 0; i < tiles.size(); ++i) {
      const Tile& tile = tiles[uniform_index(rng, tiles.size())];
      part += tile.sum;
      pixels += tile.pixels;
    }
    drawn.push_back(root_of(part, pixels));
  }
  std::sort(drawn.begin(), drawn.end());
  return {root_of(sum, static_cast<double>(image.size())), drawn[kResamples / 40],
          drawn[kResamples - 1 - kResamples / 40]};
}

}  // namespace

double luminance(const Rgbf& c) {
  return 0.2126 * static_cast<double>(c.r) + 0.7152 * static_cast<double>(c.g) +
         0.0722 * static_cast<double>(c.b);
}

double mean_luminance(const Image<Rgbf>& image) {
  double sum = 0;
  for (const Rgbf& c : image) sum += luminance(c);
  return sum / static_cast<double>(std::max<std::size_t>(image.size(), 1));
}

Reference merge_passes(std::span<const Image<Rgbf>> passes) {
  if (passes.size() < 2) throw std::invalid_argument("reference: needs two passes or more");
  for (const Image<Rgbf>& pass : passes) require_same_size(passes[0], pass);
  const auto n = static_cast<double>(passes.size());
  Reference reference;
  reference.mean = Image<Rgbf>(passes[0].width(), passes[0].height());
  reference.luminance_variance = Image<float>(passes[0].width(), passes[0].height());
  for (std::size_t i = 0; i < reference.mean.size(); ++i) {
    double r = 0, g = 0, b = 0, mean = 0, squares = 0;
    for (const Image<Rgbf>& pass : passes) {
      const Rgbf& c = pass.data()[i];
      r += static_cast<double>(c.r);
      g += static_cast<double>(c.g);
      b += static_cast<double>(c.b);
      mean += luminance(c) / n;
    }
    for (const Image<Rgbf>& pass : passes) {
      const double d = luminance(pass.data()[i]) - mean;
      squares += d * d;
    }
    reference.mean.data()[i] = {static_cast<float>(r / n), static_cast<float>(g / n),
                                static_cast<float>(b / n)};
    reference.luminance_variance.data()[i] = static_cast<float>(squares / (n - 1) / n);
  }
  return reference;
}

WithInterval reference_error(const Image<Rgbf>& image, const Reference& reference, Rng rng) {
  require_same_size(image, reference.mean);
  const double floor = 0.1 * mean_luminance(reference.mean);
  return root_mean(image, rng, [&](int x, int y) {
    const double truth = luminance(reference.mean(x, y));
    const double d = luminance(image(x, y)) - truth;
    const double scale = truth + floor;
    const auto own = static_cast<double>(reference.luminance_variance(x, y));
    return scale > 0 ? (d * d - own) / (scale * scale) : 0.0;
  });
}

WithInterval pair_error(const Image<Rgbf>& a, const Image<Rgbf>& b, Rng rng) {
  require_same_size(a, b);
  const double floor = 0.05 * (mean_luminance(a) + mean_luminance(b));
  return root_mean(a, rng, [&](int x, int y) {
    const double p = luminance(a(x, y)), q = luminance(b(x, y));
    const double scale = 0.5 * (p + q) + floor;
    return scale > 0 ? 0.5 * (p - q) * (p - q) / (scale * scale) : 0.0;
  });
}

}  // namespace cousin
