// A fruit's surface: closed forms, and derivatives against differences.
#include "perception/fruit/fruit_shape.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sim/types/rng.h"

namespace cousin {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

FruitShape odd_shape() {
  FruitShape shape = mean_shape(FruitPrior{});
  Rng rng(3);
  FruitParameters by = FruitParameters::Zero();
  for (int k = 0; k < kFruitNumbers; ++k) by[k] = 0.02 * normal(rng);
  by[kTurnX] = 0.4;
  return changed(shape, by);
}

TEST(FruitShape, ASphereHasItsVolumeAndExtents) {
  FruitShape ball;
  ball.numbers[kLogRadius] = std::log(0.04);
  const FruitNumbers numbers = numbers_of(ball);
  EXPECT_NEAR(numbers.volume_m3.value, 4 * std::numbers::pi / 3 * std::pow(0.04, 3),
              1e-3 * numbers.volume_m3.value);        // the midpoint rule over 36 rows: 3e-4
  EXPECT_NEAR(numbers.diameter_m.value, 0.08, 1e-4);  // no row stands on the equator: cos 2.5 deg
  EXPECT_NEAR(numbers.length_m.value, 0.08, 1e-4);
  EXPECT_NEAR(distance_to(ball, {0.05, 0, 0}, true).distance_m, 0.01, 1e-12);
}

TEST(FruitShape, TheMeanHasThePriorsExtents) {
  const FruitPrior prior;
  const FruitNumbers numbers = numbers_of(mean_shape(prior));
  EXPECT_NEAR(numbers.diameter_m.value, prior.diameter_m, 1e-3 * prior.diameter_m);
  EXPECT_NEAR(numbers.length_m.value / numbers.diameter_m.value, prior.shape_index, 2e-3);
}

TEST(FruitShape, PointsOfItsSurfaceHaveNoDistance) {
  const FruitShape shape = odd_shape();
  for (const Eigen::Vector3d& p : points_of(shape, 12, 7))
    EXPECT_NEAR(distance_to(shape, p, true).distance_m, 0, 1e-9);
}

TEST(FruitShape, DerivativesAreThoseOfDifferences) {
  const FruitShape shape = odd_shape();
  const Eigen::Vector3d point_m = points_of(shape, 9, 5)[16] * 1.02;
  const FruitDistance at = distance_to(shape, point_m, true);
  const FruitNumbers numbers = numbers_of(shape);
  constexpr double kStep = 1e-6;
  for (int k = 0; k < kFruitNumbers; ++k) {
    SCOPED_TRACE(k);
    FruitParameters by = FruitParameters::Zero();
    by[k] = kStep;
    const FruitShape up = changed(shape, by), down = changed(shape, -by);
    const auto slope = [&](auto value) { return (value(up) - value(down)) / (2 * kStep); };
    // The slope that makes a distance of the radial difference is held: second order in a distance
    // of 2 %.
    EXPECT_NEAR(
        slope([&](const FruitShape& s) { return distance_to(s, point_m, true).distance_m; }),
        at.derivative[k], 0.03 * (std::abs(at.derivative[k]) + 0.04));
    if (k < kLogRadius) continue;
    EXPECT_NEAR(slope([](const FruitShape& s) { return numbers_of(s).volume_m3.value; }),
                numbers.volume_m3.derivative[k], 1e-8);
    EXPECT_NEAR(slope([](const FruitShape& s) { return numbers_of(s).diameter_m.value; }),
                numbers.diameter_m.derivative[k], 1e-6);
  }
}

TEST(FruitShape, APriorOutOfItsLimitsIsRefusedByKey) {
  EXPECT_THAT([] { validate(FruitPrior{.shape_index = 9}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("shape_index")));
}

}  // namespace
}  // namespace cousin
