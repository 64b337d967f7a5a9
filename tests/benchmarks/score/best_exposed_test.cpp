#include "benchmarks/score/best_exposed.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/imaging/color.h"

namespace cousin {
namespace {

constexpr int kWidth = 200, kHeight = 130;  // more pixels than the factor is found by

FidelityPlanes shades(double factor) {
  FidelityPlanes planes;
  for (std::size_t c = 0; c < 3; ++c) {
    planes[c] = Image<float>(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const double light = 0.02 + 0.3 * x / kWidth + 0.1 * static_cast<double>(c) * y / kHeight;
        planes[c](x, y) = srgb_from_linear(static_cast<float>(factor * light));
      }
    }
  }
  return planes;
}

TEST(BestExposed, AFactorOfLightIsTakenOut) {
  const Image<std::uint8_t> all(kWidth, kHeight, 255);
  for (const double factor : {0.3, 0.9, 1.0, 1.7}) {
    const FidelityPlanes image = shades(1), photograph = shades(factor);
    const FidelityPlanes exposed = best_exposed(image, photograph, all);
    EXPECT_GT(psnr_db(exposed, photograph, all), 80) << factor;
    // No mask says the same as one that leaves all: a pinhole's photograph has none.
    EXPECT_EQ(best_exposed(image, photograph, {})[1], exposed[1]) << factor;
  }
}

TEST(BestExposed, WhatIsMaskedDoesNotCountAndNothingIsNoFactor) {
  Image<std::uint8_t> mask(kWidth, kHeight, 255);
  FidelityPlanes photograph = shades(1.5);
  for (int y = 0; y < kHeight / 2; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      mask(x, y) = 0;
      for (Image<float>& channel : photograph) channel(x, y) = 0;
    }
  }
  EXPECT_GT(psnr_db(best_exposed(shades(1), photograph, mask), photograph, mask), 80);
  const Image<std::uint8_t> none(kWidth, kHeight);
  const FidelityPlanes same = best_exposed(shades(1), photograph, none);
  EXPECT_EQ(same[0](50, 50), shades(1)[0](50, 50));
}

// What clips has two least values: the better is a factor of eight.
TEST(BestExposed, OfTwoLeastValuesTheLesser) {
  const Image<std::uint8_t> all(kWidth, kHeight, 255);
  FidelityPlanes image, photograph;
  for (std::size_t c = 0; c < 3; ++c) {
    image[c] = Image<float>(kWidth, kHeight, srgb_from_linear(0.5F));
    photograph[c] = Image<float>(kWidth, kHeight, 0.5F);
    for (int y = 0; y < kHeight * 2 / 5; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        image[c](x, y) = srgb_from_linear(0.02F);
        photograph[c](x, y) = 1;
      }
    }
  }
  EXPECT_GT(best_exposed(image, photograph, all)[0](0, 0), srgb_from_linear(0.15F));
}

// No other factor is better: what it is for.
TEST(BestExposed, OthersAreWorse) {
  const Image<std::uint8_t> all(kWidth, kHeight, 255);
  FidelityPlanes image = shades(1), photograph = shades(1.4);
  for (std::size_t i = 0; i < image[0].size(); ++i) {  // not the same scene
    image[1].data()[i] *= 0.8F;
    photograph[2].data()[i] = 0.3F;
  }
  const FidelityPlanes best = best_exposed(image, photograph, all);
  const double found = psnr_db(best, photograph, all);
  EXPECT_GT(found, psnr_db(image, photograph, all));
  for (const double by : {0.97, 1.03}) {
    FidelityPlanes other = best;
    for (Image<float>& channel : other) {
      for (std::size_t i = 0; i < channel.size(); ++i) {
        float& value = channel.data()[i];
        value = srgb_from_linear(static_cast<float>(by) * linear_from_srgb(value));
      }
    }
    EXPECT_LT(psnr_db(other, photograph, all), found + 1e-4) << by;
  }
}

}  // namespace
}  // namespace cousin
