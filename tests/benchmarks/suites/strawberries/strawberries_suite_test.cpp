#include "benchmarks/suites/strawberries/strawberries_suite.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace cousin {
namespace {

TEST(StrawberriesSuite, AJobIsAStretchOfBed) {
  const std::vector<ShardJob> quick = strawberries_suite_jobs({.quick = true});
  ASSERT_EQ(quick.size(), 3U + 5);
  EXPECT_EQ(quick.front().name, "quick_bed_run0.json");
  EXPECT_EQ(quick.back().name, "quick_camera_kinect-v2_run0.json");
  const std::vector<ShardJob> full = strawberries_suite_jobs({});
  EXPECT_EQ(full.size(), 10U + 3 + 1 + 5 * 3);
  std::set<std::string> keys;
  for (const ShardJob& job : full) keys.insert(job.key);
  EXPECT_EQ(keys.size(), full.size());
}

TEST(StrawberriesSuite, APointThatIsOffFailsItsLimit) {
  ScoreFile jobs;
  for (int i = 0; i < 10; ++i) {
    SpecimenRow row;
    row.scene = "bed";
    row.run = "bed_run0";
    row.frame = 0;
    row.instance = i;
    row.method = "ours";
    row.unit = "m";
    row.cultivar = "akihime";
    for (const char* axis : {"x", "y", "z"}) {
      row.trait = std::string("point_") + axis;
      row.truth = 0.4;
      row.measured = 0.4012;
      row.sigma = 0.001;
      jobs.specimens.push_back(row);
    }
    row.trait = "volume";
    row.unit = "m3";
    row.cultivar = "akihime, unoccluded";
    row.truth = 1e-5;
    row.measured = 1.05e-5;
    row.sigma = 5e-7;
    jobs.specimens.push_back(row);
  }
  int seen = 0;
  for (const ScoreRow& row : strawberries_pooled_rows(jobs, 1)) {
    if (row.case_name != "all" || row.scene != "pooled") continue;
    if (row.metric == "point.rmse_x" || row.metric == "point.rmse_z") {
      ++seen;
      EXPECT_NEAR(row.value, 0.0012, 1e-12);
      EXPECT_EQ(row.status, row.metric == "point.rmse_z" ? ScoreStatus::pass : ScoreStatus::fail);
    }
    if (row.metric == "volume.mape") {
      ++seen;
      EXPECT_EQ(row.status, ScoreStatus::pass);
    }
  }
  EXPECT_EQ(seen, 3);
}

TEST(StrawberriesSuite, ThePageComparesTheCamerasAndSaysWhatItDares) {
  SeedsReport report;
  ScoreRow row;
  row.suite = "strawberries";
  row.scene = "pooled";
  row.method = "ours";
  row.case_name = "d405, all";
  row.metric = "centre.rmse_3d";
  row.value = 0.0021;
  report.scores.scores = {row};
  row.case_name = "all, surest 50 %";
  row.metric = "volume.mape";
  row.value = 0.03;
  report.scores.scores.push_back(row);
  add_strawberries_plots(report);
  ASSERT_EQ(report.tables.size(), 1U);
  EXPECT_EQ(report.tables[0].lines[0][0], "d405");
  EXPECT_EQ(report.tables[0].lines[0][3], "2.1");
  ASSERT_EQ(report.lines.size(), 1U);
  EXPECT_EQ(report.lines[0].series[0].points[0].x, 50);
  SeedsReport other;
  add_strawberries_plots(other);
  EXPECT_TRUE(other.tables.empty());
}

}  // namespace
}  // namespace cousin
