#include "benchmarks/suites/phone/phone_suite.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace cousin {
namespace {

TEST(PhoneSuite, EachWayMeasuresTheSameSeeds) {
  const std::vector<ShardJob> quick = phone_suite_jobs({.quick = true});
  ASSERT_EQ(quick.size(), 5U);
  EXPECT_EQ(quick.front().name, "quick_zhengdan958_calibrated.json");
  EXPECT_EQ(quick.back().name, "quick_zhengdan958_sheet.json");
  const std::vector<ShardJob> full = phone_suite_jobs({.runs = 3});
  EXPECT_EQ(full.size(), 3U * 3U * 5U);
  std::set<std::string> keys;
  for (const ShardJob& job : full) keys.insert(job.key);
  EXPECT_EQ(keys.size(), full.size());
}

/// Two runs of two cultivars whose lengths err by `error_m`, one up, the next down.
void add_seeds(const std::string& way, double error_m, std::vector<SpecimenRow>& rows) {
  for (int i = 0; i < 20; ++i) {
    SpecimenRow row;
    row.cultivar = i % 4 < 2 ? "jimai22" : "suijing18";
    row.run = i < 10 ? "run0" : "run1";
    row.instance = i;
    row.method = way;
    row.trait = "length";
    row.unit = "m";
    row.truth = 0.006 + 0.0001 * i;
    row.measured = row.truth + (i % 2 == 0 ? error_m : -error_m);
    row.sigma = error_m;
    rows.push_back(row);
  }
}

TEST(PhoneSuite, AWayThatDoublesTheErrorBreaksItsLimit) {
  std::vector<SpecimenRow> rows;
  add_seeds("calibrated", 1e-4, rows);
  add_seeds("video", 1.2e-4, rows);
  add_seeds("sheet", 2e-4, rows);
  add_seeds("blind", 3e-4, rows);
  int seen = 0;
  for (const ScoreRow& row : phone_pooled_rows(rows, 1)) {
    if (row.metric != "length.rmse_ratio" || row.case_name != "all") continue;
    ++seen;
    if (row.method == "video/calibrated") {
      EXPECT_NEAR(row.value, 1.2, 1e-9);
      EXPECT_EQ(row.status, ScoreStatus::pass);
    } else if (row.method == "sheet/calibrated") {
      EXPECT_NEAR(row.value, 2, 1e-9);
      EXPECT_EQ(row.status, ScoreStatus::fail);
    } else {
      EXPECT_EQ(row.method, "blind/calibrated");
      EXPECT_EQ(row.status, ScoreStatus::ok);
    }
  }
  EXPECT_EQ(seen, 3);
}

}  // namespace
}  // namespace cousin
