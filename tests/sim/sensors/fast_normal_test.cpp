#include "sim/sensors/fast_normal.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cousin {
namespace {

TEST(NormalQuantile, InvertsTheDistributionFunction) {
  for (const double p : {1e-300, 1e-12, 1e-4, 0.02, 0.3, 0.5, 0.9, 0.999}) {
    const double x = normal_quantile(p);
    // Newton stops at rounding; log P amplifies it by |x|, at most 37.
    EXPECT_NEAR(0.5 * std::erfc(-x / std::sqrt(2.0)) / p, 1, 1e-12) << p;
  }
  EXPECT_EQ(normal_quantile(0.5), 0);
}

// Every 1024th value of the 32 bits: a quadrature, not a sample, so the tolerances are the table's
// own error.
TEST(NormalTable, HasTheMomentsOfTheStandardNormal) {
  const NormalTable table;
  double m1 = 0, m2 = 0, m3 = 0, m4 = 0;
  constexpr std::uint32_t kCount = 1U << 22;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const double z = table(i * 1024 + 511);
    m1 += z;
    m2 += z * z;
    m3 += z * z * z;
    m4 += z * z * z * z;
  }
  EXPECT_NEAR(m1 / kCount, 0, 1e-5);
  EXPECT_NEAR(m2 / kCount, 1, 1e-5);
  EXPECT_NEAR(m3 / kCount, 0, 1e-4);
  EXPECT_NEAR(m4 / kCount, 3, 2e-3);
}

TEST(NormalTable, FollowsTheQuantileIntoTheTails) {
  const NormalTable table;
  for (const std::uint32_t bits : {0U, 1U, 1000U, 1U << 20, 123456789U, 2000000000U, 4294967295U}) {
    const double exact = normal_quantile((bits + 0.5) * 0x1.0p-32);
    // Linear interpolation is worst in the second bin, whose ends differ by 0.2.
    EXPECT_NEAR(table(bits), exact, 0.01) << bits;
  }
  EXPECT_LT(table(0), -6.2F);
}

}  // namespace
}  // namespace cousin
