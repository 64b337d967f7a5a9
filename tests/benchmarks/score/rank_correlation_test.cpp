#include "benchmarks/score/rank_correlation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <vector>

namespace cousin {
namespace {

TEST(RankCorrelation, OfAnyIncreasingFunctionIsOne) {
  std::vector<double> a, b, c;
  for (int i = 0; i < 20; ++i) {
    a.push_back(i);
    b.push_back(std::exp(i));
    c.push_back(-i * i * i);
  }
  EXPECT_NEAR(rank_correlation(a, b, Rng(1)).value, 1, 1e-12);
  EXPECT_NEAR(rank_correlation(a, c, Rng(1)).value, -1, 1e-12);
  EXPECT_NEAR(rank_correlation(a, b, Rng(1)).low, 1, 1e-12);
}

TEST(RankCorrelation, WithoutTiesIsSpearmansFormula) {
  const std::vector<double> a = {1, 2, 3, 4, 5}, b = {2, 1, 4, 3, 5};
  // 1 - 6 sum d^2 / (n (n^2 - 1)) = 1 - 24 / 120.
  EXPECT_NEAR(rank_correlation(a, b, Rng(1)).value, 0.8, 1e-12);
}

TEST(RankCorrelation, TiesShareTheirMeanRank) {
  const std::vector<double> a = {1, 1, 2}, b = {1, 2, 3};
  // Ranks 0.5 0.5 2 against 0 1 2: sum of products 1.5, of squares 1.5 and 2.
  EXPECT_NEAR(rank_correlation(a, b, Rng(1)).value, 1.5 / std::sqrt(3.0), 1e-12);
}

TEST(RankCorrelation, IntervalHoldsZeroForIndependentValues) {
  Rng rng(7);
  std::vector<double> a, b;
  for (int i = 0; i < 200; ++i) {
    a.push_back(normal(rng));
    b.push_back(normal(rng));
  }
  const WithInterval r = rank_correlation(a, b, Rng(1));
  EXPECT_LT(r.low, 0);
  EXPECT_GT(r.high, 0);
  // Its standard error is 1 / sqrt(199) = .071: the interval is 3.9 of them wide, to a fifth.
  EXPECT_NEAR(r.high - r.low, 3.92 * 0.071, 0.2 * 3.92 * 0.071);
}

TEST(RankCorrelation, RefusesWhatIsNoPairs) {
  const std::vector<double> a = {1, 2, 3}, b = {1, 2}, c = {1, 2, std::nan("")};
  EXPECT_THROW(rank_correlation(a, b, Rng(1)), std::invalid_argument);
  EXPECT_THROW(rank_correlation(a, c, Rng(1)), std::invalid_argument);
  EXPECT_TRUE(std::isnan(rank_correlation(b, b, Rng(1)).value));
  const std::vector<double> same = {4, 4, 4};
  EXPECT_TRUE(std::isnan(rank_correlation(a, same, Rng(1)).value));
}

}  // namespace
}  // namespace cousin
