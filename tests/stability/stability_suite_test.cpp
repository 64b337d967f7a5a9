#include <gtest/gtest.h>

#include <map>

#include "benchmarks/stability/suite.h"

namespace cousin {
namespace {

TEST(StabilitySuite, EveryCaseHoldsItsLimit) {
  const ScoreFile file = stability_suite(true);
  std::map<ScoreStatus, int> count;
  for (const ScoreRow& row : file.scores) {
    ++count[row.status];
    EXPECT_NE(row.status, ScoreStatus::fail)
        << row.case_name << ", " << row.metric << " " << row.value << " " << row.unit;
    EXPECT_NE(row.status, ScoreStatus::error) << row.case_name << ": " << row.metric;
  }
  EXPECT_GT(count[ScoreStatus::pass], 40);
}

}  // namespace
}  // namespace cousin
