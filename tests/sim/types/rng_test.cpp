#include "sim/types/rng.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace cousin {
namespace {

TEST(Rng, ForksAreTheirOwnStreamsAndLeaveTheParentAlone) {
  Rng parent(7);
  Rng untouched(7);
  std::set<std::uint64_t> first_draws;
  for (std::uint64_t i = 0; i < 1000; ++i) first_draws.insert(parent.fork(i)());
  first_draws.insert(parent.fork("shape")());
  first_draws.insert(parent.fork("noise")());
  EXPECT_EQ(first_draws.size(), 1002U);
  EXPECT_EQ(parent(), untouched());
}

TEST(Rng, ForkDoesNotDependOnHowFarTheParentAdvanced) {
  Rng advanced(7);
  for (int i = 0; i < 5; ++i) advanced();
  EXPECT_EQ(advanced.fork("x")(), Rng(7).fork("x")());
}

TEST(Rng, NormalHasUnitMoments) {
  Rng rng(3);
  constexpr int kCount = 200000;
  double sum = 0, sum2 = 0, sum4 = 0;
  for (int i = 0; i < kCount; ++i) {
    const double z = normal(rng);
    sum += z;
    sum2 += z * z;
    sum4 += z * z * z * z;
  }
  // Standard errors: 1/sqrt(n), sqrt(2/n), sqrt(96/n); allow five.
  EXPECT_NEAR(sum / kCount, 0, 5 / std::sqrt(kCount));
  EXPECT_NEAR(sum2 / kCount, 1, 5 * std::sqrt(2.0 / kCount));
  EXPECT_NEAR(sum4 / kCount, 3, 5 * std::sqrt(96.0 / kCount));
}

TEST(Rng, PoissonHasItsMeanAndVarianceOnBothBranches) {
  for (const double mean : {0.0, 0.3, 5.0, 29.0, 31.0, 2000.0}) {
    Rng rng(11);
    constexpr int kCount = 100000;
    double sum = 0, sum2 = 0;
    for (int i = 0; i < kCount; ++i) {
      const double count = poisson(rng, mean);
      sum += count;
      sum2 += (count - mean) * (count - mean);
    }
    EXPECT_NEAR(sum / kCount, mean, 5 * std::sqrt(mean / kCount) + 1e-12);
    // Rounding adds 1/12 to the variance of the normal branch: 0.3 % at its start.
    EXPECT_NEAR(sum2 / kCount, mean,
                (5 * std::sqrt(2.0 / kCount) + 0.003) * mean + 5 * std::sqrt(mean / kCount));
  }
}

TEST(Rng, UniformIndexStaysBelowItsCount) {
  Rng rng(5);
  for (int i = 0; i < 1000; ++i) EXPECT_LT(uniform_index(rng, 7), 7U);
}

}  // namespace
}  // namespace cousin
