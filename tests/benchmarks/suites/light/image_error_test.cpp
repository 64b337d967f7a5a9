#include "benchmarks/suites/light/image_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <vector>

#include "benchmarks/suites/light/reference_store.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

/// 1 with independent noise of `sigma`, times `gain`: what a renderer of a known error would make.
Image<Rgbf> noisy(double sigma, double gain, std::uint64_t seed) {
  Rng rng(seed);
  Image<Rgbf> image(128, 96);
  for (Rgbf& c : image) {
    const auto v = static_cast<float>(gain * (1 + sigma * normal(rng)));
    c = {v, v, v};
  }
  return image;
}

Reference reference_of(double sigma, int passes) {
  std::vector<Image<Rgbf>> images;
  for (int i = 0; i < passes; ++i) images.push_back(noisy(sigma, 1, 100 + i));
  return merge_passes(images);
}

// The error's scale is truth + a tenth of the mean: 1.1. 12,288 pixels know a variance to 1.3 %, a
// sigma to 0.64 %; four of these.
constexpr double kTolerance = 0.026;

TEST(ImageError, OfKnownNoiseIsThatNoise) {
  const double expected = 0.1 / 1.1;
  EXPECT_NEAR(pair_error(noisy(0.1, 1, 1), noisy(0.1, 1, 2), Rng(1)).value, expected,
              kTolerance * expected);
  // The reference's own noise, half as large as the image's, is taken off.
  EXPECT_NEAR(reference_error(noisy(0.1, 1, 1), reference_of(0.1, 4), Rng(1)).value, expected,
              2 * kTolerance * expected);
}

TEST(ImageError, OnlyAReferenceShowsABias) {
  // 5 % too bright: pairs of such images do not know.
  const double noise = 0.02 / 1.1;
  EXPECT_NEAR(pair_error(noisy(0.02, 1.05, 1), noisy(0.02, 1.05, 2), Rng(1)).value, noise,
              kTolerance * noise);
  const double both = std::hypot(0.02 * 1.05, 0.05) / 1.1;
  EXPECT_NEAR(reference_error(noisy(0.02, 1.05, 1), reference_of(0.02, 16), Rng(1)).value, both,
              kTolerance * both);
}

TEST(ImageError, IntervalsHoldTheTruthAndShrinkWithTheImage) {
  int inside = 0;
  for (std::uint64_t s = 0; s < 40; ++s) {
    const WithInterval e = pair_error(noisy(0.1, 1, 2 * s), noisy(0.1, 1, 2 * s + 1), Rng(s));
    inside += e.low <= 0.1 / 1.1 && 0.1 / 1.1 <= e.high ? 1 : 0;
    EXPECT_LT(e.high - e.low, 0.1 * e.value);
  }
  EXPECT_GE(inside, 33);  // of 38 expected; fewer has a chance of 0.3 %
}

TEST(ImageError, SizesMustAgree) {
  EXPECT_THROW(pair_error(noisy(0, 1, 1), Image<Rgbf>(3, 3), Rng(1)), std::invalid_argument);
  EXPECT_THROW(merge_passes(std::vector<Image<Rgbf>>(1, noisy(0, 1, 1))), std::invalid_argument);
}

TEST(ReferenceStore, PassesAreMadeOnceAndGoOnWhereTheyStopped) {
  const fs::path folder = fs::path(testing::TempDir()) / "reference_store";
  fs::remove_all(folder);
  int made = 0;
  const auto passes = [&](const char* key, int count) {
    return reference_passes(folder, "ours", key, count, [&](int pass) {
      ++made;
      return noisy(0.1, 1, static_cast<std::uint64_t>(pass));
    });
  };
  const auto first = passes("k", 2);
  EXPECT_EQ(made, 2);
  const auto more = passes("k", 3);
  EXPECT_EQ(made, 3);
  EXPECT_EQ(more[0], first[0]);  // bit by bit through the file
  EXPECT_EQ(more[1], first[1]);
  passes("another", 1);
  EXPECT_EQ(made, 4);
  fs::remove_all(folder);
}

}  // namespace
}  // namespace cousin
