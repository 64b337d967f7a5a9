#include "benchmarks/suites/plants/plants_suite.h"

#include <gtest/gtest.h>

#include <map>

namespace cousin {
namespace {

TEST(PlantsSuite, EveryPublishedNumberAndLimitIsKept) {
  const ScoreFile file = plants_suite(1, true);
  std::map<ScoreStatus, int> count;
  for (const ScoreRow& row : file.scores) {
    if (row.unit == "s") continue;  // a machine that does other things too takes its time
    ++count[row.status];
    EXPECT_NE(row.status, ScoreStatus::fail)
        << row.case_name << ", " << row.metric << " " << row.value << " " << row.unit;
    EXPECT_NE(row.status, ScoreStatus::error) << row.case_name << ": " << row.metric;
  }
  EXPECT_GE(count[ScoreStatus::pass], 11);  // without MuJoCo: sizes, maturity and red share
}

}  // namespace
}  // namespace cousin
