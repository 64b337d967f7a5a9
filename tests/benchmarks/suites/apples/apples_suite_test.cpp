#include "benchmarks/suites/apples/apples_suite.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace cousin {
namespace {

TEST(ApplesSuite, AJobIsATreeOfOneOcclusion) {
  const std::vector<ShardJob> quick = apples_suite_jobs({.quick = true});
  ASSERT_EQ(quick.size(), 5U + 5);
  EXPECT_EQ(quick.front().name, "quick_hidden_0_run0.json");
  EXPECT_EQ(quick.back().name, "quick_camera_kinect-v2_0_run0.json");
  const std::vector<ShardJob> full = apples_suite_jobs({.runs = 2});
  EXPECT_EQ(full.size(), 2U * (4 + 1 + 1 + 1 + 5));
  std::set<std::string> keys;
  for (const ShardJob& job : full) keys.insert(job.key);
  EXPECT_EQ(keys.size(), full.size());
}

/// 20 apples of 0.2 to 0.3 kg whose masses err by a share, one up, the next down.
void add_apples(const std::string& method, const std::string& name, double share,
                std::vector<SpecimenRow>& rows) {
  for (int i = 0; i < 20; ++i) {
    SpecimenRow row;
    row.scene = "fuji";
    row.cultivar = "fuji, " + name;
    row.run = i < 10 ? "run0" : "run1";
    row.frame = i % 2;
    row.instance = i / 2;  // each fruit is in two frames
    row.method = method;
    row.trait = "mass";
    row.unit = "kg";
    row.truth = 0.2 + 0.005 * i;
    row.measured = row.truth * (1 + (i % 4 < 2 ? share : -share));
    row.sigma = share * row.truth;
    rows.push_back(row);
  }
}

TEST(ApplesSuite, ErrorsAboveTheirLimitFailAndBoxesArePaired) {
  ScoreFile jobs;
  add_apples("ours", "unoccluded", 0.02, jobs.specimens);
  add_apples("ours", "hidden below 40 %", 0.06, jobs.specimens);
  add_apples("paper", "unoccluded", 0.04, jobs.specimens);
  int seen = 0;
  for (const ScoreRow& row : apples_pooled_rows(jobs, 1)) {
    if (row.metric == "mass.mape" && row.method == "ours" && row.case_name == "unoccluded") {
      ++seen;
      EXPECT_NEAR(row.value, 0.02, 1e-9);
      EXPECT_EQ(row.status, ScoreStatus::pass);
    }
    if (row.metric == "mass.mape" && row.case_name == "hidden below 40 %") {
      ++seen;
      EXPECT_NEAR(row.value, 0.06, 1e-9);
      EXPECT_EQ(row.status, ScoreStatus::fail);
    }
    if (row.metric == "mass.rmse_ratio" && row.method == "ours/paper" &&
        row.case_name == "unoccluded") {
      ++seen;
      EXPECT_EQ(row.n, 20);  // not 10: each frame's box is one of its own
      EXPECT_NEAR(row.value, 0.5, 1e-9);
    }
  }
  EXPECT_EQ(seen, 3);
}

TEST(ApplesSuite, WidthOfIntervalsIsOverTheError) {
  ScoreFile jobs;
  add_apples("ours", "unoccluded", 0.02, jobs.specimens);
  for (const ScoreRow& row : apples_pooled_rows(jobs, 1)) {
    if (row.metric != "mass.width_over_rmse" || row.case_name != "all") continue;
    EXPECT_NEAR(row.value, 3.92, 0.05);  // sigma is the error: twice 1.96 but for spread of sizes
    return;
  }
  FAIL() << "no such row";
}

}  // namespace
}  // namespace cousin
