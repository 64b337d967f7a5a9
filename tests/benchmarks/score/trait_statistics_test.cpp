#include "benchmarks/score/trait_statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "benchmarks/score/distributions.h"

namespace cousin {
namespace {

std::vector<TraitPair> pairs_of(const std::vector<double>& truth,
                                const std::vector<double>& measured) {
  std::vector<TraitPair> pairs;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    pairs.push_back(
        {.truth = truth[i], .measured = measured[i], .run = "run " + std::to_string(i / 2)});
  }
  return pairs;
}

TEST(TraitStatistics, TruthScoresPerfectly) {
  const std::vector<double> truth = {0.010, 0.011, 0.0095, 0.0102, 0.0108};
  const TraitStatistics s = trait_statistics(pairs_of(truth, truth), Rng(1));
  EXPECT_EQ(s.n, 5);
  EXPECT_EQ(s.runs, 3);
  EXPECT_TRUE(s.by_run);
  for (const WithInterval& zero : {s.rmse, s.mape, s.bias, s.limit_low, s.limit_high}) {
    EXPECT_EQ(zero.value, 0);
    EXPECT_EQ(zero.low, 0);
    EXPECT_EQ(zero.high, 0);
  }
  EXPECT_EQ(s.slope.value, 1);
  EXPECT_NEAR(s.intercept.value, 0, 1e-17);
  EXPECT_EQ(s.r2_about_true_mean.value, 1);
  EXPECT_EQ(s.r2_paper.value, 1);
}

TEST(TraitStatistics, AKnownOffsetScoresItself) {
  const TraitStatistics s =
      trait_statistics(pairs_of({10, 11, 12, 13}, {10.5, 11.5, 12.5, 13.5}), Rng(1));
  EXPECT_NEAR(s.rmse.value, 0.5, 1e-12);
  EXPECT_NEAR(s.bias.value, 0.5, 1e-12);
  EXPECT_NEAR(s.slope.value, 1, 1e-12);
  EXPECT_NEAR(s.intercept.value, 0.5, 1e-12);
  EXPECT_NEAR(s.limit_low.value, 0.5, 1e-7);  // the spread of e is zero to the root of rounding
  EXPECT_NEAR(s.mape.value, (0.5 / 10 + 0.5 / 11 + 0.5 / 12 + 0.5 / 13) / 4, 1e-12);
}

TEST(TraitStatistics, FormulasAgreeWithAHandCalculation) {
  // true 1 2 3 4, measured 1 2 4 5: e = 0 0 1 1; sum e^2 = 2; about the true mean 2.5: 5; about the
  // measured mean 3: 10.
  const TraitStatistics s = trait_statistics(pairs_of({1, 2, 3, 4}, {1, 2, 4, 5}), Rng(1));
  EXPECT_NEAR(s.rmse.value, std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(s.bias.value, 0.5, 1e-12);
  EXPECT_NEAR(s.r2_about_true_mean.value, 1 - 2.0 / 5, 1e-12);
  EXPECT_NEAR(s.r2_paper.value, 1 - 2.0 / 10, 1e-12);
  // Slope: sum (t - 2.5)(m - 3) = 3 + .5 + .5 + 3 = 7, over 5; the line passes through (2.5, 3).
  EXPECT_NEAR(s.slope.value, 1.4, 1e-12);
  EXPECT_NEAR(s.intercept.value, 3 - 1.4 * 2.5, 1e-12);
  EXPECT_NEAR(s.mape.value, (1.0 / 3 + 1.0 / 4) / 4, 1e-12);
  // Standard deviation of 0 0 1 1 with n - 1: sqrt(1/3).
  EXPECT_NEAR(s.limit_high.value, 0.5 + kSigmas95 * std::sqrt(1.0 / 3), 1e-12);
}

TEST(TraitStatistics, KeepsItsDigitsForSmallSpreadsFarFromZero) {
  // A spread of 1e-6 about 1e6: sums of squares of the raw values would leave no digit.
  std::vector<double> truth, measured;
  for (int i = 0; i < 8; ++i) {
    truth.push_back(1e6 + i);
    measured.push_back(1e6 + 1.25 * i);
  }
  EXPECT_NEAR(trait_statistics(pairs_of(truth, measured), Rng(1)).slope.value, 1.25, 1e-12);
}

TEST(TraitStatistics, DoesNotDependOnTheOrderOfThePairs) {
  std::vector<TraitPair> pairs;
  Rng rng(3);
  for (int i = 0; i < 50; ++i) {
    const double truth = 5 + normal(rng);
    pairs.push_back(
        {.truth = truth, .measured = truth + 0.1 * normal(rng), .run = std::to_string(i % 5)});
  }
  const TraitStatistics a = trait_statistics(pairs, Rng(1));
  std::reverse(pairs.begin(), pairs.end());
  std::rotate(pairs.begin(), pairs.begin() + 13, pairs.end());
  const TraitStatistics b = trait_statistics(pairs, Rng(1));
  EXPECT_EQ(a.rmse.value, b.rmse.value);
  EXPECT_EQ(a.rmse.low, b.rmse.low);
  EXPECT_EQ(a.slope.high, b.slope.high);
}

TEST(TraitStatistics, SaysWhatItCannotTell) {
  EXPECT_TRUE(std::isnan(trait_statistics({}, Rng(1)).rmse.value));
  const TraitStatistics one = trait_statistics(pairs_of({2}, {2.5}), Rng(1));
  EXPECT_EQ(one.rmse.value, 0.5);
  EXPECT_TRUE(std::isnan(one.rmse.low));
  EXPECT_TRUE(std::isnan(one.slope.value));
  EXPECT_TRUE(std::isnan(one.r2_about_true_mean.value));
  const TraitStatistics run = trait_statistics(pairs_of({2, 3}, {2.5, 3.1}), Rng(1));
  EXPECT_FALSE(run.by_run);
  EXPECT_LT(run.rmse.low, run.rmse.high);
  EXPECT_THROW(trait_statistics(pairs_of({2}, {std::nan("")}), Rng(1)), std::invalid_argument);
}

/// Share of simulated experiments whose 95 % interval of the bias holds the true bias 0.3. Runs
/// share an offset.
double bias_coverage(int runs, double run_sigma) {
  int covered = 0;
  constexpr int kExperiments = 400;
  for (int experiment = 0; experiment < kExperiments; ++experiment) {
    Rng rng = Rng(17).fork(static_cast<std::uint64_t>(experiment));
    std::vector<TraitPair> pairs;
    for (int run = 0; run < runs; ++run) {
      const double offset = 0.3 + run_sigma * normal(rng);
      for (int i = 0; i < 10; ++i) {
        const double truth = 10 + normal(rng);
        pairs.push_back(
            {.truth = truth, .measured = truth + offset + normal(rng), .run = std::to_string(run)});
      }
    }
    const WithInterval bias =
        trait_statistics(pairs, rng.fork("bootstrap"), {.resamples = 500}).bias;
    covered += bias.low <= 0.3 && 0.3 <= bias.high ? 1 : 0;
  }
  return static_cast<double>(covered) / kExperiments;
}

TEST(TraitStatistics, IntervalsCoverTheTruthWhenRunsShareAnError) {
  // 400 experiments know a coverage of 95 % to 1.1 %. Five runs are the fewest a benchmark uses;
  // there the bootstrap of five values is coarse, so the lower bound is wider.
  const double five = bias_coverage(5, 1);
  EXPECT_GT(five, 0.90);
  EXPECT_LT(five, 0.99);
  const double twenty = bias_coverage(20, 1);
  EXPECT_GT(twenty, 0.92);
  EXPECT_LT(twenty, 0.98);
}

TEST(SigmaCoverage, CountsHonestSigmasAsHonest) {
  Rng rng(5);
  std::vector<TraitPair> pairs;
  for (int i = 0; i < 4000; ++i) {
    const double sigma = uniform(rng, 0.1, 2);
    pairs.push_back({.truth = 5, .measured = 5 + sigma * normal(rng), .sigma = sigma});
  }
  pairs.push_back({.truth = 5, .measured = 99});  // without a sigma: not counted
  const SigmaCoverage coverage = sigma_coverage(pairs);
  EXPECT_EQ(coverage.n, 4000);
  EXPECT_NEAR(coverage.within_68.value, 0.6827, 4 * 0.0074);  // sqrt(p (1 - p) / n)
  EXPECT_NEAR(coverage.within_95.value, 0.95, 4 * 0.0034);
  EXPECT_NEAR(coverage.normalised_rms, 1, 4 / std::sqrt(8000.0));
  EXPECT_LT(coverage.within_95.low, coverage.within_95.value);
  EXPECT_EQ(sigma_coverage({}).n, 0);
}

TEST(ComparePaired, RatioAndTestAgreeWithAHandCalculation) {
  // |e_a| = 1 2 1 2, |e_b| = 2 2 3 3: differences -1 0 -2 -1, mean -1, sd sqrt(2/3), t = -1 / (sd /
  // 2).
  const std::vector<PairedMeasurement> pairs = {
      {10, 11, 12, "a"}, {20, 18, 22, "a"}, {30, 31, 27, "b"}, {40, 42, 43, "b"}};
  const PairedComparison c = compare_paired(pairs, Rng(1));
  EXPECT_NEAR(c.rmse_ratio.value, std::sqrt((1 + 4 + 1 + 4) / (4.0 + 4 + 9 + 9)), 1e-12);
  EXPECT_NEAR(c.absolute_difference.value, -1, 1e-12);
  EXPECT_NEAR(c.t, -2 / std::sqrt(2.0 / 3), 1e-12);
  EXPECT_NEAR(c.p_value, student_t_two_sided(c.t, 3), 1e-15);
  EXPECT_EQ(c.runs, 2);
  EXPECT_LE(c.rmse_ratio.low, c.rmse_ratio.value);
  EXPECT_GE(c.rmse_ratio.high, c.rmse_ratio.value);
}

TEST(ComparePaired, AMethodAgainstItselfShowsNoDifference) {
  const PairedComparison c = compare_paired(
      std::vector<PairedMeasurement>{{1, 1.1, 1.1, "a"}, {2, 2.3, 2.3, "b"}, {3, 2.9, 2.9, "c"}},
      Rng(1));
  EXPECT_EQ(c.rmse_ratio.value, 1);
  EXPECT_EQ(c.rmse_ratio.low, 1);
  EXPECT_EQ(c.absolute_difference.value, 0);
  EXPECT_TRUE(std::isnan(c.p_value));  // no spread, no test
}

}  // namespace
}  // namespace cousin
