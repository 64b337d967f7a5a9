#include "benchmarks/seeds/limits.h"

#include <gtest/gtest.h>

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

ScoreStatus held(ScoreRow row) {
  std::vector<ScoreRow> rows = {std::move(row)};
  hold_to_limits(rows);
  return rows[0].status;
}

TEST(SeedsLimits, ASpeciesIsHeldToItsOwnLimit) {
  EXPECT_EQ(held(pooled("maize", "length.rmse", 0.00014)), ScoreStatus::pass);
  EXPECT_EQ(held(pooled("maize", "length.rmse", 0.00016)), ScoreStatus::fail);
  EXPECT_EQ(held(pooled("wheat", "length.rmse", 0.00014)), ScoreStatus::fail);
  EXPECT_EQ(held(pooled("rice", "height.rmse", 0.00007)), ScoreStatus::pass);
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

TEST(SeedsLimits, SeedsThatAreNotMeasuredFail) {
  EXPECT_EQ(held(pooled("rice", "length.solved", 0)), ScoreStatus::fail);
  EXPECT_EQ(held(pooled("rice", "length.solved", 0.95)), ScoreStatus::pass);
}

TEST(SeedsLimits, RunsOfManyViewsAreHeldToTheirSpeciesLimit) {
  ScoreRow row = pooled("jimai22 run 0 270 views 1920x1080", "curve.width.rmse", 0.00009);
  row.scene = "jimai22";
  EXPECT_EQ(held(row), ScoreStatus::fail);
  row.scene = "zhengdan958";
  row.case_name = "zhengdan958 run 0 270 views 1920x1080";
  EXPECT_EQ(held(row), ScoreStatus::pass);
  row.case_name = "zhengdan958 run 0 120 views 1920x1080";
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
