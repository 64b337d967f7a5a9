// A fruit's surface under the middle of its box: what hides it, what is missing, how sure it is.
#include "perception/fruit/fruit_point.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "sim/types/rng.h"

namespace cousin {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double kRadius_m = 0.015, kSigma_m = 0.001;
const Camera kCamera{LensModel::pinhole, 160, 120, 400, 400, 79.5, 59.5, {}, {}};

/// A ball before a wall at 0.7 m, seen at `centre_px`; its front is at 0.5 m.
struct Ball {
  FrameDepth depth;
  DetectedBox box;
};
Ball ball(const Eigen::Vector2d& centre_px, double noise_m, Rng rng) {
  Ball made;
  made.depth.depth_m = Image<float>(160, 120, 0.7F);
  made.depth.sigma_m = Image<float>(160, 120, static_cast<float>(kSigma_m));
  const double centre_z_m = 0.5 + kRadius_m;
  Eigen::Vector2d low(1e9, 1e9), high(-1e9, -1e9);
  Image<std::uint8_t> mask(160, 120);
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      const Eigen::Vector2d at = (Eigen::Vector2d(x, y) - centre_px) * (0.5 / 400);
      const double left = kRadius_m * kRadius_m - at.squaredNorm();
      if (left <= 0) continue;
      made.depth.depth_m(x, y) = static_cast<float>(centre_z_m - std::sqrt(left));
      mask(x, y) = 255;
      low = low.cwiseMin(Eigen::Vector2d(x, y));
      high = high.cwiseMax(Eigen::Vector2d(x, y));
    }
  }
  for (float& z : made.depth.depth_m) z += static_cast<float>(noise_m * normal(rng));
  made.box.low_px = low.array() - 0.5;
  made.box.high_px = high.array() + 0.5;
  made.box.mask = mask;
  made.box.image_px = {160, 120};
  return made;
}

TEST(FruitPoint, ABallsFrontIsFoundThoughItIsCurved) {
  const Ball made = ball({79, 59}, 0, Rng(1));
  const FruitPoint ours = point_by_patch(made.depth, kCamera, made.box);
  ASSERT_EQ(ours.why_none, "");
  EXPECT_NEAR(ours.point_m.z(), 0.5, 5e-5);
  const FruitPoint paper = point_by_paper(made.depth, kCamera, made.box);
  EXPECT_NEAR(paper.point_m.z(), 0.5, 1e-6);
  EXPECT_TRUE(std::isnan(paper.covariance_m2(2, 2)));
}

TEST(FruitPoint, WhatHangsBeforeTheFruitHasNoPartInIt) {
  Ball made = ball({79, 59}, 0, Rng(1));
  // A leaf over its middle and right; the mask shows the fruit beside it.
  for (int y = 40; y < 80; ++y) {
    for (int x = 78; x < 100; ++x) {
      made.depth.depth_m(x, y) = 0.45F;
      made.box.mask(x, y) = 0;
    }
  }
  const FruitPoint ours = point_by_patch(made.depth, kCamera, made.box);
  ASSERT_EQ(ours.why_none, "");
  EXPECT_NEAR(ours.point_m.z(), 0.5, 5e-4);
  EXPECT_NEAR(point_by_paper(made.depth, kCamera, made.box).point_m.z(), 0.45, 1e-6);
}

TEST(FruitPoint, WhereDepthIsMissingOursSaysSoAndThePaperTakesTheWindow) {
  Ball made = ball({79, 59}, 0, Rng(1));
  made.depth.depth_m(79, 59) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_NEAR(point_by_paper(made.depth, kCamera, made.box).point_m.z(), 0.5, 3e-4);
  // Most of the fruit is missing, as nearer than the sensor can see: what is left is the wall's.
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      if (made.box.mask(x, y) && (x + y) % 4 != 0)
        made.depth.depth_m(x, y) = std::numeric_limits<float>::quiet_NaN();
    }
  }
  EXPECT_THAT(point_by_patch(made.depth, kCamera, made.box).why_none,
              HasSubstr("pixels about its middle have depth"));
  made.depth.depth_m = {};
  EXPECT_EQ(point_by_patch(made.depth, kCamera, made.box).why_none, "the frame has no depth");
  EXPECT_EQ(point_by_paper(made.depth, kCamera, made.box).why_none, "the frame has no depth");
}

TEST(FruitPoint, ADepthThatANeighbourMayHaveLentIsNotAsserted) {
  Ball made = ball({79, 59}, 0, Rng(1));
  // The sensor has the depth of the leaf beside and on the fruit, at 0.4 m; the mask shows the
  // fruit.
  for (int y = 30; y < 90; ++y) {
    for (int x = 50; x < 110; ++x) made.depth.depth_m(x, y) = 0.4F;
  }
  EXPECT_THAT(point_by_patch(made.depth, kCamera, made.box).why_none, HasSubstr("neighbour"));
  // If what is beside it is another fruit in a box of its own, it is no neighbour to fear.
  DetectedBox other = made.box;
  other.id = made.box.id + 1;
  other.mask = Image<std::uint8_t>(160, 120, 255);
  other.mask_at_px = {0, 0};
  const DetectedBox boxes[] = {made.box, other};
  EXPECT_EQ(point_by_patch(made.depth, kCamera, made.box, boxes).why_none, "");
}

TEST(FruitPoint, ABoxFarLargerThanItsImageCostsNoMoreThanTheImage) {
  Ball made = ball({79, 59}, 0, Rng(1));
  made.box.low_px = {-1e6 + 79, -1e6 + 59};
  made.box.high_px = {1e6 + 79, 1e6 + 59};
  const FruitPoint point = point_by_patch(made.depth, kCamera, made.box);  // 10^12 pixels else
  ASSERT_EQ(point.why_none, "");
  EXPECT_NEAR(point.point_m.z(), 0.5, 0.02);
}

TEST(FruitPoint, ABoxOutOfTheImageIsNoPoint) {
  Ball made = ball({79, 59}, 0, Rng(1));
  made.box.mask = {};
  made.box.low_px = {500, 500};
  made.box.high_px = {520, 520};
  EXPECT_NE(point_by_patch(made.depth, kCamera, made.box).why_none, "");
  EXPECT_NE(point_by_paper(made.depth, kCamera, made.box).why_none, "");
}

TEST(FruitPoint, SigmasCoverWhatDepthsOfOneUnitAreOff) {
  int within = 0;
  constexpr int kRuns = 200;
  FruitPointConfig config;
  config.correlated_px = 1;  // this noise is each pixel's own
  for (int run = 0; run < kRuns; ++run) {
    Rng rng = Rng(5).fork(static_cast<std::uint64_t>(run));
    Ball made = ball({79, 59}, kSigma_m, rng.fork("noise"));
    const auto off_m = static_cast<float>(kSigma_m * normal(rng));  // the unit's own
    for (float& z : made.depth.depth_m) z += off_m;
    const FruitPoint point = point_by_patch(made.depth, kCamera, made.box, {}, config);
    ASSERT_EQ(point.why_none, "");
    if (std::abs(point.point_m.z() - 0.5) < 1.96 * std::sqrt(point.covariance_m2(2, 2))) ++within;
  }
  EXPECT_GE(within, 0.90 * kRuns);
  EXPECT_LE(within, 0.99 * kRuns);
}

TEST(FruitPoint, ItsConfigurationIsChecked) {
  EXPECT_THAT([] { validate(FruitPointConfig{.window_share = 0}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("window_share")));
}

}  // namespace
}  // namespace cousin
