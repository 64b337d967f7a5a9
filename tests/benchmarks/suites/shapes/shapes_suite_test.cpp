#include "benchmarks/suites/shapes/shapes_suite.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace cousin {
namespace {

TEST(ShapesSuite, FourRunsOfEachShapeAreJobsOfTheirOwn) {
  const std::vector<ShardJob> jobs = shapes_suite_jobs({});
  EXPECT_EQ(jobs.size(), 20U);
  std::set<std::string> keys;
  for (const ShardJob& job : jobs) keys.insert(job.key);
  EXPECT_EQ(keys.size(), jobs.size());
  EXPECT_EQ(shapes_suite_jobs({.quick = true}).size(), 5U);
  EXPECT_NE(shapes_suite_jobs({.seed = 2}).front().key, jobs.front().key);
}

/// Forty heights that err by `error_m` about `bias_m` and say `sigma_m`.
std::vector<SpecimenRow> heights(double bias_m, double error_m, double sigma_m) {
  std::vector<SpecimenRow> rows;
  for (int i = 0; i < 40; ++i) {
    SpecimenRow row;
    row.cultivar = "pea";
    row.run = "run" + std::to_string(i / 10);
    row.instance = i;
    row.method = "ours";
    row.trait = "height";
    row.unit = "m";
    row.truth = 0.007;
    row.measured = row.truth + bias_m + (i % 2 == 0 ? error_m : -error_m);
    row.sigma = sigma_m;
    rows.push_back(row);
  }
  return rows;
}

const ScoreRow* find(const std::vector<ScoreRow>& rows, const std::string& metric) {
  for (const ScoreRow& row : rows) {
    if (row.metric == metric && row.case_name == "pea") return &row;
  }
  return nullptr;
}

TEST(ShapesSuite, IntervalsThatAreTooNarrowOrTooWideMissTheirLimits) {
  const auto narrow = shapes_pooled_rows(heights(0, 1e-4, 4e-5), 1);
  ASSERT_NE(find(narrow, "traits.coverage_95"), nullptr);
  EXPECT_EQ(find(narrow, "traits.coverage_95")->value, 0);
  EXPECT_EQ(find(narrow, "traits.coverage_95")->status, ScoreStatus::fail);
  EXPECT_EQ(find(narrow, "height.width_over_rmse")->status, ScoreStatus::pass);
  const auto wide = shapes_pooled_rows(heights(0, 1e-4, 2e-4), 1);
  EXPECT_EQ(find(wide, "traits.coverage_95")->value, 1);
  EXPECT_EQ(find(wide, "traits.coverage_95")->status, ScoreStatus::fail);
  EXPECT_NEAR(find(wide, "height.width_over_rmse")->value, 2 * 1.959963985 * 2, 1e-6);
  EXPECT_EQ(find(wide, "height.width_over_rmse")->status, ScoreStatus::fail);
}

TEST(ShapesSuite, ABiasOfHeightBeyondItsLimitIsTold) {
  EXPECT_EQ(find(shapes_pooled_rows(heights(4e-5, 1e-4, 1e-4), 1), "height.bias")->status,
            ScoreStatus::pass);
  EXPECT_EQ(find(shapes_pooled_rows(heights(-6e-5, 1e-4, 1e-4), 1), "height.bias")->status,
            ScoreStatus::fail);
}

}  // namespace
}  // namespace cousin
