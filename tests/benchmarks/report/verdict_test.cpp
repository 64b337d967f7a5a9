// A page begins with how many were measured, how wrong, and what the limits say.
#include "benchmarks/report/verdict.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cousin {
namespace {

SpecimenRow specimen(const char* method, int instance, ScoreStatus status, int frame = -1) {
  SpecimenRow row;
  row.method = method;
  row.instance = instance;
  row.frame = frame;
  row.trait = "length";
  row.status = status;
  return row;
}

ScoreRow pooled(const char* metric, const char* group, double value, double low, double high) {
  ScoreRow row;
  row.scene = "pooled";
  row.case_name = group;
  row.method = "ours";
  row.metric = metric;
  row.unit = "m";
  row.value = value;
  row.ci_low = low;
  row.ci_high = high;
  return row;
}

TEST(Verdict, SaysHowManyOfHowManyAndHowWrongWithItsInterval) {
  ScoreFile file;
  file.specimens = {specimen("paper", 1, ScoreStatus::ok), specimen("ours", 1, ScoreStatus::ok),
                    specimen("ours", 2, ScoreStatus::not_solved)};
  file.scores = {pooled("length.rmse", "maize", 0.00009, 0, 0),
                 pooled("length.rmse", "all", 0.00005, 0.00004, 0.00006),
                 pooled("width.bias", "all", 1, 1, 1)};
  EXPECT_EQ(verdict(file),
            "1 of 2 specimens are measured by ours: RMSE of length 0.0500 [0.0400, 0.0600] mm.");
  file.scores.push_back(limited(pooled("length.slope", "all", 1, 1, 1), at_most(0)));
  EXPECT_THAT(verdict(file), testing::EndsWith(" 0 of 1 numbers keep their limit."));
}

TEST(Verdict, OfBoxesAndOfLimitsAlone) {
  ScoreFile file;
  file.specimens = {specimen("paper", 1, ScoreStatus::ok, 0),
                    specimen("paper", 1, ScoreStatus::ok, 1)};
  EXPECT_EQ(verdict(file), "2 of 2 objects in images are measured by paper.");
  file.specimens.clear();
  EXPECT_EQ(verdict(file), "");
  file.scores = {limited(pooled("x", "all", 1, 1, 1), at_most(2))};
  EXPECT_EQ(verdict(file), "1 of 1 numbers keep their limit.");
}

}  // namespace
}  // namespace cousin
