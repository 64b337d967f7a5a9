// The paper's chain from a box to a mass.
#include "perception/fruit/fruit_clv.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "tests/perception/fruit/drawn_fruit.h"

namespace cousin {
namespace {

FruitShape clv_ball() {
  FruitShape ball;
  ball.numbers[kLogRadius] = std::log(0.04);
  ball.numbers[kCentreZ] = 0.5;
  return ball;
}

TEST(FruitClv, AnUndeformedSphereOfABallsBoxIsTheBall) {
  const DrawnFruit drawn = draw_fruit(clv_ball(), 0, Rng(1));
  ClvConfig config;
  config.wave_strength = config.noise = config.stalk_dent = config.calyx_dent = 0;
  config.correction = 0;
  config.points = 20000;
  const FruitFit fit = fit_clv(drawn.depth, kFruitCamera, drawn.box, config, Rng(1));
  ASSERT_EQ(fit.status, FitStatus::ok);
  // The box is of whole pixels, of 63; a hull of so many points lacks 0.1 %.
  EXPECT_NEAR(fit.diameter_m.value, 0.08, 0.025 * 0.08);
  EXPECT_NEAR(fit.volume_m3.value, 4 * std::numbers::pi / 3 * std::pow(fit.diameter_m.value / 2, 3),
              0.005 * fit.volume_m3.value);
  EXPECT_NEAR(fit.mass_kg.value, config.density_kg_m3 * fit.volume_m3.value, 1e-12);
}

TEST(FruitClv, WhatHidesPartOfTheBoxTakesPartOfTheMass) {
  DrawnFruit drawn = draw_fruit(clv_ball(), 0, Rng(1));
  const double whole_kg = fit_clv(drawn.depth, kFruitCamera, drawn.box, {}, Rng(1)).mass_kg.value;
  hide_from_column(drawn, 110, 0.42);
  EXPECT_LT(fit_clv(drawn.depth, kFruitCamera, drawn.box, {}, Rng(1)).mass_kg.value,
            0.85 * whole_kg);
}

TEST(FruitClv, WithoutDepthInItsMiddleThereIsNone) {
  DrawnFruit drawn = draw_fruit(clv_ball(), 0, Rng(1));
  for (float& z : drawn.depth.depth_m) z = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(fit_clv(drawn.depth, kFruitCamera, drawn.box, {}, Rng(1)).reason,
            "no depth in the middle of its box");
  drawn.depth.depth_m = {};
  EXPECT_EQ(fit_clv(drawn.depth, kFruitCamera, drawn.box, {}, Rng(1)).reason,
            "the frame has no depth");
}

TEST(FruitClv, ItsConfigurationIsChecked) {
  EXPECT_THAT([] { validate(ClvConfig{.points = 3}); },
              testing::ThrowsMessage<std::invalid_argument>(testing::HasSubstr("points")));
}

TEST(FruitClv, ABoxOfNoSizeOrWiderThanItsDistanceIsNoFruit) {
  DrawnFruit drawn = draw_fruit(apple_at_half_a_metre(0.2), 0, Rng(1));
  const Eigen::Vector2d middle = 0.5 * (drawn.box.low_px + drawn.box.high_px);
  for (const double half_px : {0.0, 1e6}) {
    drawn.box.low_px = middle.array() - half_px;
    drawn.box.high_px = middle.array() + half_px;
    const FruitFit fit = fit_clv(drawn.depth, kFruitCamera, drawn.box, {}, Rng(1));
    EXPECT_NE(fit.status, FitStatus::ok);
    EXPECT_THAT(fit.reason, testing::HasSubstr("its box is no fruit's"));
  }
}

}  // namespace
}  // namespace cousin
