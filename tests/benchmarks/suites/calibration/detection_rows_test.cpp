// benchmarks/suites/calibration/detection_rows.h: targets in rendered boards, held against the
// truth.
#include "benchmarks/suites/calibration/detection_rows.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cousin {
namespace {

using testing::HasSubstr;

TEST(DetectionRows, RenderedBoardsAreFoundWithinTheLimitsAndOpenCvsCharucoIsHalfAPixelOff) {
  const std::vector<ScoreRow> rows = detection_rows(1, true);
  int held = 0, offsets = 0;
  for (const ScoreRow& row : rows) {
    if (row.metric.find("(at ") != std::string::npos) {
      EXPECT_EQ(row.status, ScoreStatus::pass)
          << row.case_name << ": " << row.metric << " = " << row.value;
      ++held;
    } else if (row.metric.find("mean offset") != std::string::npos) {
      // Half a pixel, to what corners on 8 bits and 60 of them leave.
      EXPECT_NEAR(row.value, 0.5, 0.05) << row.metric;
      ++offsets;
    }
  }
  EXPECT_EQ(held, 13);
  EXPECT_EQ(offsets, 2);
}

}  // namespace
}  // namespace cousin
