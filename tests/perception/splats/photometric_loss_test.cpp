#include "perception/splats/photometric_loss.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <limits>

#include "sim/types/rng.h"

namespace cousin {
namespace {

using Kernel = PhotometricConfig::Kernel;

/// Smooth patterns and noise in 0..1.
ColorPlanes picture(int width, int height, std::uint64_t seed) {
  Rng rng(seed);
  ColorPlanes planes;
  for (std::size_t c = 0; c < 3; ++c) {
    planes.channel[c] = Image<float>(width, height);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const double wave = std::sin(0.3 * x + static_cast<double>(c)) * std::cos(0.2 * y);
        const double value = 0.5 + 0.25 * wave + 0.25 * (uniform(rng) - 0.5);
        planes.channel[c](x, y) = static_cast<float>(value);
      }
    }
  }
  return planes;
}

Image<float> ragged_weight(int width, int height) {
  Image<float> weight(width, height);
  Rng rng(3);
  for (float& w : weight) {
    const double u = uniform(rng);
    w = u < 0.3 ? 0.0f : static_cast<float>(u);
  }
  return weight;
}

/// The loss by its definition, one window at a time, in double.
struct Direct {
  const ColorPlanes& rendered;
  const ColorPlanes& photograph;
  const Image<float>& weight;
  double share;

  double weight_at(int x, int y) const {
    if (!rendered.channel[0].contains(x, y)) return 0;
    return weight.empty() ? 1.0 : static_cast<double>(weight(x, y));
  }
  double similarity(std::size_t c, int x, int y) const {
    double norm = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
    for (int dy = -5; dy <= 5; ++dy) {
      for (int dx = -5; dx <= 5; ++dx) {
        const double g = std::exp(-(dx * dx + dy * dy) / (2 * 1.5 * 1.5));
        norm += g;
        if (!(weight_at(x + dx, y + dy) > 0)) continue;
        const double p = static_cast<double>(rendered.channel[c](x + dx, y + dy));
        const double q = static_cast<double>(photograph.channel[c](x + dx, y + dy));
        a += g * p, b += g * q, aa += g * p * p, bb += g * q * q, ab += g * p * q;
      }
    }
    a /= norm, b /= norm, aa /= norm, bb /= norm, ab /= norm;
    const double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
    return (2 * a * b + c1) * (2 * (ab - a * b) + c2) /
           ((a * a + b * b + c1) * (aa - a * a + bb - b * b + c2));
  }
  /// Sum of the terms of the pixels within `reach` of (x0, y0), over the sum of all weights.
  double value(std::size_t c, int x0, int y0, int reach) const {
    double sum = 0;
    for (int y = y0 - reach; y <= y0 + reach; ++y) {
      for (int x = x0 - reach; x <= x0 + reach; ++x) {
        const double w = weight_at(x, y);
        if (!(w > 0)) continue;
        const double difference = std::abs(static_cast<double>(rendered.channel[c](x, y)) -
                                           static_cast<double>(photograph.channel[c](x, y)));
        sum += w * ((1 - share) * difference + share * (1 - similarity(c, x, y)));
      }
    }
    return sum / (3 * total());
  }
  double total() const {
    double total = 0;
    for (int y = 0; y < rendered.channel[0].height(); ++y) {
      for (int x = 0; x < rendered.channel[0].width(); ++x) total += weight_at(x, y);
    }
    return total;
  }
};

/// Value against the definition, and the gradient against its central differences, everywhere.
void expect_agrees_with_definition(int width, int height, const Image<float>& weight,
                                   const PhotometricConfig& config) {
  ColorPlanes rendered = picture(width, height, 1);
  const ColorPlanes photograph = picture(width, height, 2);
  PhotometricLoss loss(config);
  const LossAndGradient result = loss(rendered, photograph, weight);
  const Direct direct{rendered, photograph, weight, config.ssim_share};
  double value = 0;
  for (std::size_t c = 0; c < 3; ++c)
    value += direct.value(c, width / 2, height / 2, std::max(width, height));
  // Window sums round to 1e-7; the similarity divides them by C2 = 9e-4 at worst.
  EXPECT_NEAR(result.value, value, 2e-5);

  const double total = direct.total();
  for (std::size_t c = 0; c < 3; ++c) {
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        float& pixel = rendered.channel[c](x, y);
        const float kept = pixel;
        const float step = 1e-3f;
        // Where the difference changes its sign between the two sides, |difference| has no slope.
        if (std::abs(kept - photograph.channel[c](x, y)) < 2 * step) continue;
        pixel = kept + step;
        const double span_above = static_cast<double>(pixel - kept);
        const double above = direct.value(c, x, y, 5);
        pixel = kept - step;
        const double span = span_above + static_cast<double>(kept - pixel);
        const double below = direct.value(c, x, y, 5);
        pixel = kept;
        // Of one pixel's term, 1e-3 of the largest slopes: central differences leave the square
        // of the step times the third derivative, which C2 lets grow to 1 / C2.
        EXPECT_NEAR(static_cast<double>(result.gradient.channel[c](x, y)) * total,
                    (above - below) / span * total, 1e-3)
            << "channel " << c << ", pixel " << x << ", " << y;
      }
    }
  }
}

TEST(PhotometricLoss, ValueAndGradientAreThoseOfTheDefinition) {
  for (const Kernel kernel : {Kernel::portable, Kernel::fastest}) {
    for (const double share : {0.0, 0.2, 1.0}) {
      expect_agrees_with_definition(21, 18, {}, {.ssim_share = share, .kernel = kernel});
    }
  }
}

TEST(PhotometricLoss, ImagesSmallerThanTheWindowOrAVectorAgreeWithTheDefinition) {
  for (const Kernel kernel : {Kernel::portable, Kernel::fastest}) {
    for (const auto& [width, height] : {std::pair{1, 1}, {7, 3}, {8, 1}, {1, 40}, {9, 12}})
      expect_agrees_with_definition(width, height, {}, {.kernel = kernel});
  }
}

TEST(PhotometricLoss, WeightedPixelsAgreeWithTheDefinition) {
  for (const Kernel kernel : {Kernel::portable, Kernel::fastest})
    expect_agrees_with_definition(19, 17, ragged_weight(19, 17), {.kernel = kernel});
}

TEST(PhotometricLoss, AnImageCostsNothingAgainstItself) {
  const ColorPlanes image = picture(50, 40, 1);
  PhotometricLoss loss;
  const LossAndGradient& result = loss(image, image);
  EXPECT_EQ(result.l1, 0);
  // One rounding of the quotient, 6e-8, a pixel.
  EXPECT_NEAR(result.ssim, 1, 1e-6);
  for (const Image<float>& channel : result.gradient.channel) {
    // The three terms cancel to their own rounding: 1e-7 of slopes up to 1 / C2, per pixel.
    for (const float g : channel) EXPECT_NEAR(g, 0, 1e-4 / (3 * 50 * 40));
  }
}

TEST(PhotometricLoss, FlatImagesHaveTheClosedForm) {
  ColorPlanes a, b;
  for (std::size_t c = 0; c < 3; ++c) {
    a.channel[c] = Image<float>(40, 40, 0.6f);
    b.channel[c] = Image<float>(40, 40, 0.5f);
  }
  // A weight that is one only where no window touches the border.
  Image<float> inner(40, 40, 1e-12f);
  for (int y = 5; y < 35; ++y) {
    for (int x = 5; x < 35; ++x) inner(x, y) = 1;
  }
  PhotometricLoss loss;
  const LossAndGradient& result = loss(a, b, inner);
  EXPECT_NEAR(result.l1, 0.1, 1e-7);
  // (2 a b + C1) / (a^2 + b^2 + C1); variances are zero to 1e-7, against C2 = 9e-4.
  EXPECT_NEAR(result.ssim, (2 * 0.3 + 1e-4) / (0.36 + 0.25 + 1e-4), 2e-4);
}

TEST(PhotometricLoss, PixelsOfWeightZeroChangeNothing) {
  ColorPlanes rendered = picture(40, 30, 1);
  const ColorPlanes photograph = picture(40, 30, 2);
  const Image<float> weight = ragged_weight(40, 30);
  PhotometricLoss loss;
  const LossAndGradient before = loss(rendered, photograph, weight);
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < weight.size(); ++i) {
      if (weight.data()[i] == 0)
        rendered.channel[c].data()[i] = std::numeric_limits<float>::quiet_NaN();
    }
  }
  const LossAndGradient& after = loss(rendered, photograph, weight);
  EXPECT_EQ(after.value, before.value);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_EQ(after.gradient.channel[c], before.gradient.channel[c]);
    for (std::size_t i = 0; i < weight.size(); ++i) {
      if (weight.data()[i] == 0) EXPECT_EQ(after.gradient.channel[c].data()[i], 0);
    }
  }
}

TEST(PhotometricLoss, NoWeightAtAllIsNoLoss) {
  PhotometricLoss loss;
  const LossAndGradient& result =
      loss(picture(20, 20, 1), picture(20, 20, 2), Image<float>(20, 20, 0.0f));
  EXPECT_EQ(result.value, 0);
  for (const float g : result.gradient.channel[1]) EXPECT_EQ(g, 0);
}

TEST(PhotometricLoss, AnyNumberOfThreadsGivesTheSameBytes) {
  const ColorPlanes rendered = picture(131, 117, 1);
  const ColorPlanes photograph = picture(131, 117, 2);
  const auto with_threads = [&](int threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(threads));
    tbb::task_arena arena(threads);
    PhotometricLoss loss;
    return arena.execute([&] { return loss(rendered, photograph); });
  };
  const LossAndGradient one = with_threads(1);
  for (const int threads : {2, 3, 8}) {
    const LossAndGradient many = with_threads(threads);
    EXPECT_EQ(one.value, many.value);
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_EQ(one.gradient.channel[c], many.gradient.channel[c]);
  }
}

TEST(PhotometricLoss, OneObjectServesImagesOfAnySize) {
  PhotometricLoss reused;
  for (const auto& [width, height] : {std::pair{64, 50}, {17, 90}, {64, 50}}) {
    const ColorPlanes rendered = picture(width, height, 1);
    const ColorPlanes photograph = picture(width, height, 2);
    PhotometricLoss fresh;
    const LossAndGradient& a = reused(rendered, photograph);
    const LossAndGradient& b = fresh(rendered, photograph);
    EXPECT_EQ(a.value, b.value);
    EXPECT_EQ(a.gradient.channel[2], b.gradient.channel[2]);
  }
}

TEST(PhotometricLoss, ANaNIsNotHidden) {
  ColorPlanes rendered = picture(20, 20, 1);
  rendered.channel[1](3, 4) = std::numeric_limits<float>::quiet_NaN();
  for (const Kernel kernel : {Kernel::portable, Kernel::fastest}) {
    PhotometricLoss loss({.kernel = kernel});
    EXPECT_TRUE(std::isnan(loss(rendered, picture(20, 20, 2)).value));
  }
}

TEST(PhotometricLoss, RefusesSizesThatDifferAndWeightsThatAreNoWeights) {
  PhotometricLoss loss;
  const ColorPlanes a = picture(20, 20, 1);
  EXPECT_THROW(loss(a, picture(20, 21, 1)), std::invalid_argument);
  EXPECT_THROW(loss(ColorPlanes{}, ColorPlanes{}), std::invalid_argument);
  EXPECT_THROW(loss(a, a, Image<float>(19, 20, 1.0f)), std::invalid_argument);
  EXPECT_THROW(loss(a, a, Image<float>(20, 20, -1.0f)), std::invalid_argument);
  EXPECT_THROW(loss(a, a, Image<float>(20, 20, std::numeric_limits<float>::infinity())),
               std::invalid_argument);
  EXPECT_THROW(PhotometricLoss({.ssim_share = 1.5}), std::invalid_argument);
  EXPECT_THROW(PhotometricLoss({.ssim_share = std::nan("")}), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
