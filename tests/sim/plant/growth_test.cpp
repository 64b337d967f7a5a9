#include "sim/plant/growth.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

namespace cousin {
namespace {

TEST(BetaGrowth, GoesFromNothingToTheFinalSizeAndStays) {
  const BetaGrowth growth{.final = 0.05, .duration_days = 10, .fastest_days = 4};
  EXPECT_EQ(size_at(growth, -3), 0);
  EXPECT_EQ(size_at(growth, 0), 0);
  EXPECT_DOUBLE_EQ(size_at(growth, 10), 0.05);
  EXPECT_DOUBLE_EQ(size_at(growth, 1000), 0.05);
  double before = 0;
  for (int i = 1; i <= 100; ++i) {
    EXPECT_GT(size_at(growth, 0.1 * i), before);
    before = size_at(growth, 0.1 * i);
  }
}

TEST(BetaGrowth, IsFastestOnTheDayStated) {
  const BetaGrowth growth{.final = 1, .duration_days = 12, .fastest_days = 5};
  double fastest = 0, day = 0;
  for (double t = 0.005; t < 12; t += 0.01) {
    const double rate = size_at(growth, t + 0.005) - size_at(growth, t - 0.005);
    if (rate > fastest) {
      fastest = rate;
      day = t;
    }
  }
  EXPECT_NEAR(day, 5, 0.01);  // the step
}

TEST(BetaGrowth, RefusesDurationsOutOfOrder) {
  EXPECT_THROW(size_at({1, 5, 5}, 1), std::invalid_argument);
  EXPECT_THROW(size_at({1, 5, -1}, 1), std::invalid_argument);
  EXPECT_THROW(size_at({1, 0, 0}, 1), std::invalid_argument);
}

TEST(Logistic, IsAHalfInTheMiddleAndAQuarterNearIt) {
  EXPECT_DOUBLE_EQ(logistic(3, 3, 0.5), 0.5);
  EXPECT_NEAR(logistic(3 - 1.0986 * 0.5, 3, 0.5), 0.25, 1e-4);  // ln 3 = 1.0986
}

TEST(CheckDay, NamesTheDayAndTheLimits) {
  for (const double day : {-1.0, 1000.0, std::numeric_limits<double>::quiet_NaN()}) {
    try {
      check_day(day, 20, "seedlings");
      FAIL() << day;
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("is not in [0, 20"));
    }
  }
  EXPECT_NO_THROW(check_day(0, 20, "seedlings"));
}

}  // namespace
}  // namespace cousin
