#include "benchmarks/loop/limits.h"

#include <gtest/gtest.h>

#include <cmath>

#include "benchmarks/loop/score_seeds.h"
#include "benchmarks/score/score_columns.h"
#include "scenes/seeds/seeds_scene.h"

namespace cousin {
namespace {

ScoreRow pooled(const std::string& group, const std::string& metric, double value) {
  ScoreRow row;
  row.suite = "seeds";
  row.scene = "pooled";
  row.case_name = group;
  row.method = "ours";
  row.metric = metric;
  row.value = value;
  return row;
}

std::set<std::string> all_cultivars() {
  const std::vector<std::string> names = cultivar_names();
  return {names.begin(), names.end()};
}

ScoreStatus held(ScoreRow row, const std::set<std::string>& cultivars = all_cultivars()) {
  std::vector<ScoreRow> rows = {std::move(row)};
  hold_to_limits(rows, cultivars);
  return rows[0].status;
}

TEST(SeedsLimits, ASpeciesIsHeldToItsOwnLimit) {
  EXPECT_EQ(held(pooled("maize", "length.rmse", 0.00014)), ScoreStatus::pass);
  EXPECT_EQ(held(pooled("maize", "length.rmse", 0.00016)), ScoreStatus::fail);
  EXPECT_EQ(held(pooled("wheat", "length.rmse", 0.00014)), ScoreStatus::fail);
  EXPECT_EQ(held(pooled("rice", "height.rmse", 0.00007)), ScoreStatus::pass);
}

TEST(SeedsLimits, APartOfASpeciesIsNotHeld) {
  const ScoreRow row = pooled("maize", "length.rmse", 0.00016);
  EXPECT_EQ(held(row, {"zhengdan958"}), ScoreStatus::ok);
  EXPECT_EQ(held(row, {"zhengdan958", "tianguinuo932"}), ScoreStatus::fail);
  EXPECT_EQ(held(pooled("all", "volume.coverage_95", 1.0), {"zhengdan958", "tianguinuo932"}),
            ScoreStatus::ok);
  EXPECT_EQ(held(pooled(kSphere, "volume.mape", 0.5), {}), ScoreStatus::fail);
}

TEST(SeedsLimits, BiasAndSlopeHaveTwoSides) {
  EXPECT_EQ(held(pooled("rice", "height.bias", -0.00004)), ScoreStatus::fail);
  EXPECT_EQ(held(pooled("rice", "height.bias", 0.00004)), ScoreStatus::fail);
  EXPECT_EQ(held(pooled("rice", "height.slope", 0.96)), ScoreStatus::fail);
  EXPECT_EQ(held(pooled("rice", "height.slope", 1.02)), ScoreStatus::pass);
}

TEST(SeedsLimits, IntervalsMustNotCoverTooMuchEither) {
  EXPECT_EQ(held(pooled("all", "volume.coverage_95", 1.0)), ScoreStatus::fail);
  EXPECT_EQ(held(pooled("all", "volume.coverage_95", 0.94)), ScoreStatus::pass);
}

TEST(SeedsLimits, ANumberThatIsMissingFails) {
  EXPECT_EQ(held(pooled("wheat", "camera.centre_rms", ScoreRow::kNone)), ScoreStatus::fail);
}

TEST(SeedsLimits, ASphereThatIsNotFoundAndSigmasThatAreMissingAreRowsThatFail) {
  std::vector<SpecimenRow> specimens;
  for (int i = 0; i < 3; ++i) {
    SpecimenRow row;
    row.instance = i;
    row.cultivar = i == 0 ? kSphere : i == 1 ? "jimai22" : "suijing18";
    row.run = "0";
    row.method = "ours";
    row.trait = "volume";
    row.unit = "m3";
    row.truth = 1e-8 + 1e-10 * i;
    if (i > 0) row.measured = row.truth;
    specimens.push_back(row);
  }
  SeedsScoreLabels labels;
  labels.suite = "seeds";
  labels.scene = "pooled";
  std::vector<ScoreRow> rows = pooled_rows(specimens, labels);
  hold_to_limits(rows, all_cultivars());
  int sphere = 0, coverage = 0;
  for (const ScoreRow& row : rows) {
    const bool fails = row.status == ScoreStatus::fail && std::isnan(row.value);
    sphere += row.case_name == kSphere && row.metric == "volume.mape" && fails;
    coverage += row.case_name == "all" && row.metric == "volume.coverage_95" && fails;
  }
  EXPECT_EQ(sphere, 1);
  EXPECT_EQ(coverage, 1);
}

TEST(SeedsLimits, SeedsThatAreNotMeasuredFail) {
  EXPECT_EQ(held(pooled("rice", "length.solved", 0)), ScoreStatus::fail);
  EXPECT_EQ(held(pooled("rice", "length.solved", 0.95)), ScoreStatus::pass);
}

TEST(SeedsLimits, RunsOfManyViewsAreHeldToTheirSpeciesLimit) {
  ScoreRow row = pooled("jimai22 run 0 270 views 1920x1080", "curve.width.rmse", 0.00009);
  settings_of_schema_1(row);
  row.scene = "jimai22";
  EXPECT_EQ(held(row), ScoreStatus::fail);
  row.scene = "zhengdan958";
  row.case_name = "zhengdan958 run 0 270 views 1920x1080";
  settings_of_schema_1(row);
  row.n = 9;
  EXPECT_EQ(held(row), ScoreStatus::pass);
  row.n = 8;  // of ten seeds
  EXPECT_EQ(held(row), ScoreStatus::fail);
  row.n = 9;
  row.case_name = "zhengdan958 run 0 120 views 1920x1080";
  settings_of_schema_1(row);
  EXPECT_EQ(held(row), ScoreStatus::ok);
}

TEST(SeedsLimits, WhatIsNotOursAtThePapersImagingHasNone) {
  ScoreRow paper = pooled("maize", "length.rmse", 1);
  paper.method = "paper";
  EXPECT_EQ(held(paper), ScoreStatus::ok);
  EXPECT_EQ(held(pooled("jimai22", "length.rmse", 1)), ScoreStatus::ok);
  ScoreRow spread = pooled("maize", "length.rmse", 1);
  spread.suite = "seeds_paper_spread";
  EXPECT_EQ(held(spread), ScoreStatus::ok);
}

}  // namespace
}  // namespace cousin
