#include "benchmarks/score/image_fidelity.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cmath>

#include "benchmarks/score/separable_filter.h"
#include "sim/types/rng.h"

namespace cousin {
namespace {

FidelityPlanes flat(int width, int height, float r, float g, float b) {
  return {Image<float>(width, height, r), Image<float>(width, height, g),
          Image<float>(width, height, b)};
}

FidelityPlanes noisy(int width, int height, std::uint64_t seed) {
  Rng rng(seed);
  FidelityPlanes planes = flat(width, height, 0, 0, 0);
  for (Image<float>& channel : planes) {
    for (float& value : channel) value = static_cast<float>(uniform(rng));
  }
  return planes;
}

TEST(SeparableFilter, IsTheSumOverTapsWithEitherBorder) {
  Rng rng(1);
  const FilterTaps x = {1, 2, 3, 4, 5}, y = {-1, 0, 7};
  // Sums of 16 pixels are kept together: two such groups and what is left, none, and less than
  // taps.
  for (const auto& [width, height] : {std::pair(37, 5), {7, 5}, {2, 1}}) {
    Image<double> image(width, height);
    for (double& value : image) value = uniform(rng);
    for (const FilterBorder border : {FilterBorder::zero, FilterBorder::replicate}) {
      const Image<double> result = filtered(image, x, y, border);
      for (int v = 0; v < height; ++v) {
        for (int u = 0; u < width; ++u) {
          double sum = 0;
          for (int j = -1; j <= 1; ++j) {
            for (int i = -2; i <= 2; ++i) {
              if (border == FilterBorder::zero && !image.contains(u + i, v + j)) continue;
              sum += x[static_cast<std::size_t>(i + 2)] * y[static_cast<std::size_t>(j + 1)] *
                     image(std::clamp(u + i, 0, width - 1), std::clamp(v + j, 0, height - 1));
            }
          }
          EXPECT_NEAR(result(u, v), sum, 1e-12);
        }
      }
    }
  }
  EXPECT_TRUE(filtered(Image<double>(), x, y, FilterBorder::zero).empty());
}

TEST(ImageFidelity, EqualImagesScoreBest) {
  const FidelityPlanes image = noisy(40, 30, 1);
  const ImageFidelity score = score_fidelity(image, image);
  EXPECT_EQ(score.pixels, 1200);
  EXPECT_EQ(score.psnr_db, std::numeric_limits<double>::infinity());
  EXPECT_NEAR(score.ssim, 1, 1e-12);
  EXPECT_EQ(score.flip, 0);
}

TEST(ImageFidelity, AnOffsetHasItsPsnr) {
  // 1/4 and 1/2 are exact in floats: 20 log10(4).
  EXPECT_NEAR(psnr_db(flat(9, 8, 0.5f, 0.5f, 0.5f), flat(9, 8, 0.25f, 0.25f, 0.25f)),
              12.041199826559248, 1e-12);
  // One channel of three.
  EXPECT_NEAR(psnr_db(flat(9, 8, 0.5f, 0.5f, 0.5f), flat(9, 8, 0.25f, 0.5f, 0.5f)),
              12.041199826559248 + 10 * std::log10(3.0), 1e-12);
  // What lies beyond 0..1 is shown as its end.
  EXPECT_EQ(psnr_db(flat(9, 8, 1.5f, -1.0f, 0.5f), flat(9, 8, 1, 0, 0.5f)),
            std::numeric_limits<double>::infinity());
}

TEST(ImageFidelity, SsimOfFlatImagesIsThatOfTheirMeansAwayFromTheBorder) {
  Image<std::uint8_t> inner(30, 30, std::uint8_t{0});
  for (int y = 5; y < 25; ++y) {
    for (int x = 5; x < 25; ++x) inner(x, y) = 1;
  }
  const double expected = (2 * 0.75 * 0.5 + 1e-4) / (0.75 * 0.75 + 0.25 + 1e-4);
  EXPECT_NEAR(ssim(flat(30, 30, 0.75f, 0.75f, 0.75f), flat(30, 30, 0.5f, 0.5f, 0.5f), inner),
              expected, 1e-10);
}

TEST(ImageFidelity, SsimOfNoiseIsThatOfItsDefinition) {
  const FidelityPlanes a = noisy(16, 14, 1), b = noisy(16, 14, 2);
  double sum = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    for (int y = 0; y < 14; ++y) {
      for (int x = 0; x < 16; ++x) {
        double norm = 0, ma = 0, mb = 0, aa = 0, bb = 0, ab = 0;
        for (int dy = -5; dy <= 5; ++dy) {
          for (int dx = -5; dx <= 5; ++dx) {
            const double g = std::exp(-(dx * dx + dy * dy) / 4.5);
            norm += g;
            if (!a[c].contains(x + dx, y + dy)) continue;
            const double p = static_cast<double>(a[c](x + dx, y + dy));
            const double q = static_cast<double>(b[c](x + dx, y + dy));
            ma += g * p, mb += g * q, aa += g * p * p, bb += g * q * q, ab += g * p * q;
          }
        }
        ma /= norm, mb /= norm, aa /= norm, bb /= norm, ab /= norm;
        sum += (2 * ma * mb + 1e-4) * (2 * (ab - ma * mb) + 9e-4) /
               ((ma * ma + mb * mb + 1e-4) * (aa - ma * ma + bb - mb * mb + 9e-4));
      }
    }
  }
  EXPECT_NEAR(ssim(a, b), sum / (3 * 16 * 14), 1e-12);
}

TEST(Flip, GreenBesideBlueIsTheLargestDifference) {
  EXPECT_NEAR(flip(flat(20, 20, 0, 1, 0), flat(20, 20, 0, 0, 1)), 1, 1e-6);
}

TEST(Flip, FlatGreysHaveTheClosedForm) {
  // CIELAB of sRGB's green and blue, to the digits that colour tables print, with Hunt's factor.
  const double green = 87.7347, blue = 32.2970;
  const double largest = green - blue +
                         std::hypot(0.01 * (green * -86.1827 - blue * 79.1875),
                                    0.01 * (green * 83.1793 - blue * -107.8602));
  const double from = 0.4 * std::pow(largest, 0.7);
  const auto expected = [&](double lightness) {
    const double power = std::pow(lightness, 0.7);
    return power < from ? 0.95 * power / from : 0.95 + 0.05 * (power - from) / (from / 0.4 - from);
  };
  // White beside black: lightness differs by 100. Tables go by a matrix of rounded digits, which
  // moves the largest difference by 2e-5 of itself.
  constexpr double kTables = 5e-5;
  EXPECT_NEAR(flip(flat(20, 20, 1, 1, 1), flat(20, 20, 0, 0, 0)), expected(100), kTables);
  const auto lightness = [](double code) {
    return 116 * std::cbrt(std::pow((code + 0.055) / 1.055, 2.4)) - 16;
  };
  EXPECT_NEAR(flip(flat(20, 20, 0.5f, 0.5f, 0.5f), flat(20, 20, 0, 0, 0)), expected(lightness(0.5)),
              kTables);
  // A small difference is in the stretched part.
  EXPECT_NEAR(flip(flat(20, 20, 0.55f, 0.55f, 0.55f), flat(20, 20, 0.5f, 0.5f, 0.5f)),
              expected(lightness(0.55) - lightness(0.5)), kTables);
}

TEST(Flip, AnEdgeThatIsThereOnceIsSeenMoreThanItsShadesAlone) {
  // Two greys side by side against their mean: at the edge the feature term raises the error.
  const FidelityPlanes mean = flat(120, 40, 0.5f, 0.5f, 0.5f);
  FidelityPlanes edge = mean;
  for (Image<float>& channel : edge) {
    for (int y = 0; y < 40; ++y) {
      for (int x = 0; x < 120; ++x) channel(x, y) = x < 60 ? 0.45f : 0.55f;
    }
  }
  const Image<float> map = flip_map(edge, mean, 30);
  const Image<float> shade = flip_map(flat(120, 40, 0.55f, 0.55f, 0.55f), mean, 30);
  EXPECT_NEAR(map(118, 20), shade(60, 20), 1e-6);  // far from the edge: a flat grey
  // The strongest response of the edge filter lies a pixel or so from the step.
  float largest = 0;
  for (int x = 55; x < 65; ++x) largest = std::max(largest, map(x, 20));
  EXPECT_GT(largest, 1.2f * shade(60, 20));
}

TEST(Flip, FineChecksFadeIntoTheirMeanLightWithDistance) {
  const auto light = [](double code) { return std::pow((code + 0.055) / 1.055, 2.4); };
  const double mean = 0.5 * (light(0.45) + light(0.55));
  const auto code = static_cast<float>(1.055 * std::pow(mean, 1 / 2.4) - 0.055);
  const FidelityPlanes grey = flat(64, 64, code, code, code);
  FidelityPlanes checks = grey;
  Image<std::uint8_t> inner(64, 64, std::uint8_t{0});
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      for (Image<float>& channel : checks) channel(x, y) = (x + y) % 2 == 0 ? 0.45f : 0.55f;
      // What the filters reach from the border is repeated, so that checks become stripes there.
      inner(x, y) = x >= 30 && x < 34 && y >= 30 && y < 34 ? 1 : 0;
    }
  }
  EXPECT_GT(flip(checks, grey, inner, 10), 0.05);
  // At 67 pixels a degree the lightness filter has a sigma of 1.03 pixels and leaves
  // exp(-pi^2 sigma^2) = 3e-5 of the checks' 5 units of lightness.
  EXPECT_LT(flip(checks, grey, inner), 0.005);
  EXPECT_LT(flip(checks, grey, inner, 200), 0.005);
}

TEST(Flip, IsSymmetric) {
  const FidelityPlanes a = noisy(40, 30, 1), b = noisy(40, 30, 2);
  EXPECT_EQ(flip_map(a, b), flip_map(b, a));
}

TEST(ImageFidelity, AMaskLimitsWhatIsScored) {
  FidelityPlanes image = flat(40, 30, 0.5f, 0.5f, 0.5f);
  const FidelityPlanes photograph = image;
  for (Image<float>& channel : image) {
    for (int y = 0; y < 30; ++y) channel(0, y) = 1;
  }
  Image<std::uint8_t> mask(40, 30, std::uint8_t{0});
  for (int y = 10; y < 20; ++y) mask(35, y) = 255;
  const ImageFidelity inside = score_fidelity(image, photograph, mask);
  EXPECT_EQ(inside.pixels, 10);
  EXPECT_EQ(inside.psnr_db, std::numeric_limits<double>::infinity());
  EXPECT_NEAR(inside.ssim, 1, 1e-12);
  EXPECT_EQ(inside.flip, 0);
  EXPECT_LT(score_fidelity(image, photograph).ssim, 0.999);
  const ImageFidelity none =
      score_fidelity(image, photograph, Image<std::uint8_t>(40, 30, std::uint8_t{0}));
  EXPECT_EQ(none.pixels, 0);
  EXPECT_TRUE(std::isnan(none.psnr_db) && std::isnan(none.ssim) && std::isnan(none.flip));
}

TEST(ImageFidelity, AnyNumberOfThreadsGivesTheSameBytes) {
  const FidelityPlanes a = noisy(61, 47, 1), b = noisy(61, 47, 2);
  const auto with_threads = [&](int threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(threads));
    tbb::task_arena arena(threads);
    return arena.execute([&] { return flip_map(a, b); });
  };
  EXPECT_EQ(with_threads(1), with_threads(8));
}

TEST(ImageFidelity, RefusesSizesThatDiffer) {
  const FidelityPlanes a = flat(8, 8, 0, 0, 0), b = flat(8, 9, 0, 0, 0);
  EXPECT_THROW(psnr_db(a, b), std::invalid_argument);
  EXPECT_THROW(ssim(a, b), std::invalid_argument);
  EXPECT_THROW(flip(a, b), std::invalid_argument);
  EXPECT_THROW(flip_map(a, b), std::invalid_argument);
  EXPECT_THROW(psnr_db(a, a, Image<std::uint8_t>(8, 9)), std::invalid_argument);
  EXPECT_THROW(flip(a, a, {}, 0), std::invalid_argument);
  FidelityPlanes uneven = a;
  uneven[2] = Image<float>(7, 8);
  EXPECT_THROW(ssim(uneven, a), std::invalid_argument);
}

TEST(ImageFidelity, PhotographsAreTheirCodes) {
  Image<Rgb8> image(2, 1);
  image(1, 0) = {255, 51, 0};
  const FidelityPlanes planes = fidelity_planes(image);
  EXPECT_EQ(planes[0](1, 0), 1);
  EXPECT_EQ(planes[1](1, 0), 0.2f);
  EXPECT_EQ(planes[2](0, 0), 0);
}

}  // namespace
}  // namespace cousin
