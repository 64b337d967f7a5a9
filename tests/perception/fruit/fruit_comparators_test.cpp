// Simpler ways to a fruit's size: exact where their shape is the fruit's.
#include "perception/fruit/fruit_comparators.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/perception/fruit/drawn_fruit.h"

namespace cousin {
namespace {

FruitSurface seen(const FruitShape& shape) {
  const DrawnFruit drawn = draw_fruit(shape, 0, Rng(1));
  return fruit_surface(drawn.depth, kFruitCamera, drawn.box);
}

FruitShape ball_of(double radius_m, double stretch) {
  FruitShape ball;
  ball.numbers[kLogRadius] = std::log(radius_m);
  ball.numbers[kLogStretch] = std::log(stretch);
  ball.numbers[kCentreZ] = 0.5;
  return ball;
}

TEST(FruitComparators, ASphereIsASphereAndItsHullMostOfIt) {
  const FruitSurface surface = seen(ball_of(0.04, 1));
  const double volume_m3 = 4 * std::numbers::pi / 3 * std::pow(0.04, 3);
  EXPECT_NEAR(fit_sphere(surface).volume_m3.value, volume_m3, 1e-3 * volume_m3);
  EXPECT_NEAR(fit_ellipsoid(surface).volume_m3.value, volume_m3, 0.01 * volume_m3);
  EXPECT_NEAR(fit_allometry(surface).diameter_m.value, 0.08, 0.02 * 0.08);
  const DrawnFruit drawn = draw_fruit(ball_of(0.04, 1), 0, Rng(1));
  const double hull_m3 =
      fit_hull(fruit_surface(drawn.depth, kFruitCamera, drawn.box, {.rim_px = 1.5}))
          .volume_m3.value;
  EXPECT_LT(hull_m3, volume_m3);
  EXPECT_GT(hull_m3, 0.4 * volume_m3);
  EXPECT_TRUE(std::isnan(fit_sphere(surface).volume_m3.sigma));
}

TEST(FruitComparators, AnEllipsoidIsFoundByItsOwn) {
  const FruitShape shape = ball_of(0.04, 0.8);  // its short axis along the view
  const double volume_m3 = 0.8 * 4 * std::numbers::pi / 3 * std::pow(0.04, 3);
  const FruitFit fit = fit_ellipsoid(seen(shape));
  ASSERT_EQ(fit.status, FitStatus::ok) << fit.reason;
  EXPECT_NEAR(fit.volume_m3.value, volume_m3, 0.02 * volume_m3);
  EXPECT_GT(std::abs(fit_sphere(seen(shape)).volume_m3.value - volume_m3), 0.05 * volume_m3);
}

TEST(FruitComparators, NoSurfaceIsNoSize) {
  FruitSurface none;
  none.why_none = "nothing there";
  for (const FruitFit& fit :
       {fit_sphere(none), fit_ellipsoid(none), fit_hull(none), fit_allometry(none)}) {
    EXPECT_NE(fit.status, FitStatus::ok);
    EXPECT_EQ(fit.reason, "nothing there");
  }
}

}  // namespace
}  // namespace cousin
