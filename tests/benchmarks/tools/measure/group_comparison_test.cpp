#include "benchmarks/tools/measure/group_comparison.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/types/rng.h"

namespace cousin {
namespace {

std::vector<MeasuredRow> rows_of(const std::string& group, const std::vector<double>& lengths_mm,
                                 double sigma_mm) {
  std::vector<MeasuredRow> rows;
  for (const double length_mm : lengths_mm) {
    MeasuredRow row;
    row.sample = row.source = group;
    row.seed = static_cast<int>(rows.size());
    row.trait = "length";
    row.unit = "m";  // in millimetres
    row.value = length_mm;
    row.own_sigma = sigma_mm;
    rows.push_back(row);
  }
  return rows;
}

std::vector<MeasuredRow> both(std::vector<MeasuredRow> a, const std::vector<MeasuredRow>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

// By Welch's formulas: standard error 0.359942, 3.537396 degrees of freedom, t 2.875462, whose
// tails integrated numerically are 0.0523605; 2.925674 leaves 5 %.
TEST(CompareGroups, DifferencesAreWelchs) {
  const auto rows = both(rows_of("a", {9.8, 10.1, 10.4, 10.0, 9.9}, 0.05),
                         rows_of("b", {10.9, 11.4, 10.2, 11.8}, 0.05));
  const GroupComparison found = compare_groups(rows, {{"a", exact_print()}, {"b", exact_print()}});
  ASSERT_EQ(found.differences.size(), 1U);
  const GroupDifference& d = found.differences.front();
  EXPECT_NEAR(d.difference.value, 1.035, 1e-12);
  EXPECT_NEAR(d.difference.low, -0.018073, 1e-5);
  EXPECT_NEAR(d.difference.high, 2 * 1.035 + 0.018073, 1e-5);
  EXPECT_NEAR(d.relative.value, 1.035 / 10.04, 1e-12);
  EXPECT_NEAR(d.relative.low, -0.018073 / 10.04, 1e-6);
  EXPECT_NEAR(d.p_value, 0.0523605, 1e-5);
}

TEST(CompareGroups, TellTheMeasurementsErrorApartFromTheSeeds) {
  // Seeds of 10 +- 0.3 mm, measured with 0.4 mm.
  Rng rng(7);
  std::vector<double> lengths_mm;
  for (int i = 0; i < 4000; ++i) lengths_mm.push_back(10 + 0.3 * normal(rng) + 0.4 * normal(rng));
  const GroupComparison found =
      compare_groups(rows_of("a", lengths_mm, 0.4), {{"a", exact_print()}});
  ASSERT_EQ(found.traits.size(), 1U);
  EXPECT_NEAR(found.traits[0].sd, 0.5, 0.02);
  EXPECT_NEAR(found.traits[0].measurement_sd, 0.4, 1e-9);
  EXPECT_NEAR(found.traits[0].seed_sd, 0.3, 0.03);
  // 2 (1.96 + 0.8416)^2 (0.5 / 0.2)^2 = 98.1
  EXPECT_NEAR(found.traits[0].seeds_for_two_percent, 98, 7);
}

TEST(CompareGroups, SeeADifferenceAsOftenAsTheySay) {
  // The number of seeds that is asked for sees 2 % in four of five trials.
  Rng rng(11);
  int seen = 0;
  constexpr int kTrials = 400, kSeeds = 98;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<double> a, b;
    for (int i = 0; i < kSeeds; ++i) {
      a.push_back(10 + 0.5 * normal(rng));
      b.push_back(10.2 + 0.5 * normal(rng));
    }
    const GroupComparison found = compare_groups(both(rows_of("a", a, 0.1), rows_of("b", b, 0.1)),
                                                 {{"a", exact_print()}, {"b", exact_print()}});
    seen += found.differences[0].difference.low > 0 ? 1 : 0;
  }
  EXPECT_NEAR(static_cast<double>(seen) / kTrials, 0.8, 0.06);
}

TEST(CompareGroups, TwoPrintsMakeAnIntervalWiderAndOnePrintDoesNot) {
  const auto rows =
      both(rows_of("a", {9.9, 10.0, 10.1}, 0.01), rows_of("b", {10.0, 10.1, 10.2}, 0.01));
  const auto width = [&](const PrintScale& of_a, const PrintScale& of_b) {
    const GroupDifference d = compare_groups(rows, {{"a", of_a}, {"b", of_b}}).differences.front();
    return d.difference.high - d.difference.low;
  };
  const PrintScale one{1, 0.02, ""}, other{1.001, 0.02, ""};
  EXPECT_NEAR(width(one, one), width(exact_print(), exact_print()), 0.01);
  EXPECT_GT(width(one, other), width(one, one) + 0.3);
}

TEST(CompareGroups, OneSeedHasNoSpread) {
  const GroupComparison found =
      compare_groups(both(rows_of("a", {10}, 0.1), rows_of("b", {11}, 0.1)),
                     {{"a", exact_print()}, {"b", exact_print()}});
  EXPECT_TRUE(std::isnan(found.traits[0].sd));
  EXPECT_EQ(found.traits[0].seeds_for_two_percent, 0);
  EXPECT_TRUE(std::isnan(found.differences[0].difference.low));
  EXPECT_NEAR(found.differences[0].difference.value, 1, 1e-12);
}

}  // namespace
}  // namespace cousin
