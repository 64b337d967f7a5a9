// A whole fruit from what is seen of it: recovery, hidden parts, honest sigmas, bad input.
#include "perception/fruit/fruit_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "tests/perception/fruit/drawn_fruit.h"

namespace cousin {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

FruitFit fit_drawn(const DrawnFruit& drawn, FruitSurfaceConfig surface = {}) {
  return fit_fruit(fruit_surface(drawn.depth, kFruitCamera, drawn.box, surface),
                   kind_of(FruitPrior{}));
}

TEST(FruitFit, WithoutNoiseAFreeAppleIsFound) {
  for (const double lean : {-0.8, 0.0, 0.8}) {
    SCOPED_TRACE(lean);
    const FruitShape shape = apple_at_half_a_metre(lean);
    const FruitFit fit = fit_drawn(draw_fruit(shape, 0, Rng(1)));
    ASSERT_EQ(fit.status, FitStatus::ok) << fit.reason;
    const FruitNumbers truth = numbers_of(shape);
    // The prior pulls by a few tenths of a sigma: 0.3 % of a diameter, three times that of a
    // volume.
    EXPECT_NEAR(fit.diameter_m.value, truth.diameter_m.value, 0.01 * truth.diameter_m.value);
    EXPECT_NEAR(fit.volume_m3.value, truth.volume_m3.value, 0.025 * truth.volume_m3.value);
    EXPECT_LT((fit.shape.centre_m() - shape.centre_m()).norm(), 0.003);
  }
}

TEST(FruitFit, WhatIsHiddenIsFilledInAndWidensTheInterval) {
  const FruitShape shape = apple_at_half_a_metre(0.3);
  DrawnFruit drawn = draw_fruit(shape, 0, Rng(1));
  const FruitFit whole = fit_drawn(drawn);
  hide_from_column(drawn, 104, 0.42);  // about half
  const FruitFit half = fit_drawn(drawn);
  ASSERT_EQ(half.status, FitStatus::ok) << half.reason;
  const double truth_m3 = numbers_of(shape).volume_m3.value;
  EXPECT_NEAR(half.volume_m3.value, truth_m3, 0.1 * truth_m3);
  EXPECT_GT(half.volume_m3.sigma, whole.volume_m3.sigma);
}

TEST(FruitFit, IntervalsCoverApplesOfThePrior) {
  constexpr int kApples = 60;
  int covered = 0, solved = 0;
  FruitSurfaceConfig config;
  config.correlated_px = 1;  // this noise is each pixel's own
  for (int i = 0; i < kApples; ++i) {
    const Rng rng = Rng(11).fork(static_cast<std::uint64_t>(i));
    const FruitShape shape = drawn_apple(FruitPrior{}, rng.fork("shape"));
    const FruitFit fit = fit_drawn(draw_fruit(shape, 0.0008, rng.fork("noise")), config);
    if (fit.status != FitStatus::ok) continue;
    ++solved;
    if (std::abs(fit.volume_m3.value - numbers_of(shape).volume_m3.value) <
        1.96 * fit.volume_m3.sigma)
      ++covered;
  }
  EXPECT_GE(solved, 0.9 * kApples);
  // 95 % of 60 within three standard errors of 2.8 %.
  EXPECT_GE(covered, 0.865 * solved);
}

TEST(FruitFit, IntervalsHoldOnLumpsThatNoPriorKnows) {
  FruitPrior wild;
  wild.sigma_waves_2 = 0.06;
  wild.sigma_waves_3 = 0.06;
  wild.sigma_waves_4 = 0.05;
  FruitSurfaceConfig surface;
  surface.correlated_px = 1;
  const FruitKind apples = kind_of(FruitPrior{});
  FruitFitConfig trusting;
  trusting.strange_share = 0;
  int solved = 0, covered = 0, trusted = 0, covered_trusting = 0;
  double off = 0, off_trusting = 0;
  for (int i = 0; i < 40; ++i) {
    const Rng rng = Rng(12).fork(static_cast<std::uint64_t>(i));
    const FruitShape shape = drawn_apple(wild, rng.fork("shape"));
    const double truth_m3 = numbers_of(shape).volume_m3.value;
    const DrawnFruit drawn = draw_fruit(shape, 0.0008, rng.fork("noise"));
    const FruitSurface seen = fruit_surface(drawn.depth, kFruitCamera, drawn.box, surface);
    const auto count = [&](const FruitFit& fit, int& all, int& within, double& sum) {
      if (fit.status != FitStatus::ok) return;
      ++all;
      const double error_m3 = std::abs(fit.volume_m3.value - truth_m3);
      within += error_m3 < 1.96 * fit.volume_m3.sigma;
      sum += error_m3 / truth_m3;
    };
    count(fit_fruit(seen, apples), solved, covered, off);
    count(fit_fruit(seen, apples, trusting), trusted, covered_trusting, off_trusting);
  }
  EXPECT_GE(solved, 20);
  EXPECT_GE(covered, 0.85 * solved);
  // Without the hypothesis it is sure of what it does not know.
  EXPECT_LT(covered_trusting, 0.7 * trusted);
  EXPECT_LT(off / solved, off_trusting / trusted);
}

TEST(FruitFit, ATennisBallIsNoConfidentApple) {
  FruitShape ball;
  ball.numbers[kLogRadius] = std::log(0.0335);
  ball.numbers[kCentreZ] = 0.5;
  const FruitFit fit = fit_drawn(draw_fruit(ball, 0, Rng(1)));
  const double truth_m3 = numbers_of(ball).volume_m3.value;
  if (fit.status == FitStatus::ok)
    EXPECT_LT(std::abs(fit.volume_m3.value - truth_m3), 2.5 * fit.volume_m3.sigma);
  else
    EXPECT_NE(fit.reason, "");
}

TEST(FruitFit, MillimetresReadAsMetresAreNoApple) {
  DrawnFruit drawn = draw_fruit(apple_at_half_a_metre(0.2), 0, Rng(1));
  for (float& z : drawn.depth.depth_m) z *= 1000;
  EXPECT_NE(fit_drawn(drawn).status, FitStatus::ok);
  for (float& z : drawn.depth.depth_m) z *= 1e-6F;
  EXPECT_NE(fit_drawn(drawn).status, FitStatus::ok);
}

TEST(FruitFit, TwoFruitsInOneBoxAreNoOne) {
  FruitShape left = apple_at_half_a_metre(0.2), right = left;
  left.numbers[kCentreX] = -0.045;
  right.numbers[kCentreX] = 0.045;
  right.numbers[kCentreZ] = 0.53;
  DrawnFruit drawn = draw_fruit(left, 0, Rng(1));
  const DrawnFruit other = draw_fruit(right, 0, Rng(2));
  for (int y = 0; y < drawn.box.mask.height(); ++y) {
    for (int x = 0; x < drawn.box.mask.width(); ++x) {
      if (other.box.mask(x, y) == 0) continue;
      drawn.depth.depth_m(x, y) = std::min(drawn.depth.depth_m(x, y), other.depth.depth_m(x, y));
      drawn.box.mask(x, y) = 255;
    }
  }
  fit_box(drawn);
  EXPECT_NE(fit_drawn(drawn).status, FitStatus::ok);
}

TEST(FruitFit, WhatIsNotSeenIsThePriorAndSaysSo) {
  const FruitPrior prior;
  const FruitFit fit = unseen_fruit(kind_of(prior), "nothing there");
  EXPECT_EQ(fit.status, FitStatus::too_few_points);
  EXPECT_EQ(fit.reason, "nothing there");
  EXPECT_NEAR(fit.diameter_m.value, prior.diameter_m, 0.02 * prior.diameter_m);
  EXPECT_GT(fit.mass_kg.sigma, 2.5 * prior.sigma_diameter * fit.mass_kg.value);
}

TEST(FruitFit, ItsConfigurationIsChecked) {
  EXPECT_THAT([] { validate(FruitFitConfig{.followed = 99}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("followed")));
}

}  // namespace
}  // namespace cousin
