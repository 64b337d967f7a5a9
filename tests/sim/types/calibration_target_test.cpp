#include "sim/types/calibration_target.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <stdexcept>

namespace cousin {
namespace {

using ::testing::HasSubstr;

const std::vector<CalibrationTarget>& some() {
  static const std::vector<CalibrationTarget> kTargets = {
      {TargetKind::chessboard, 10, 7, 0.025, 0, ""},
      {TargetKind::charuco, 11, 8, 0.022, 0.73, "DICT_4X4_50"},
      {TargetKind::april_grid, 6, 5, 0.1 / 3, 0.3, ""},
      {TargetKind::circles, 8, 6, 0.03, 0.3, ""},
      {TargetKind::asymmetric_circles, 4, 11, 0.018, 0.42, ""},
      {TargetKind::seed_board, 15, 15, 0.006, 16.0 / 6, ""},
  };
  return kTargets;
}

TEST(CalibrationTarget, ReadsBackEqualFromItsText) {
  for (const CalibrationTarget& target : some()) {
    const std::string text = to_text(target);
    EXPECT_EQ(target_from_text(text), target) << text;
    EXPECT_EQ(to_text(target_from_text(text)), text);
  }
}

TEST(CalibrationTarget, PointsLieOnThePrintEachOnceAboutItsMiddle) {
  for (const CalibrationTarget& target : some()) {
    std::set<int> ids;
    Eigen::Vector2d low = Eigen::Vector2d::Constant(1), high = -low;
    const Eigen::Vector2d half = 0.5 * print_size_m(target);
    const std::vector<TargetPoint> points = target_points(target);
    for (const TargetPoint& point : points) {
      EXPECT_TRUE(ids.insert(point.id).second) << to_text(target) << ", id " << point.id;
      EXPECT_TRUE((point.at_m.cwiseAbs().array() < half.array()).all()) << to_text(target);
      low = low.cwiseMin(point.at_m);
      high = high.cwiseMax(point.at_m);
    }
    EXPECT_LT((low + high).norm(), 1e-15) << to_text(target);  // rounding
  }
}

TEST(CalibrationTarget, CountsThePointsOfEachKind) {
  const std::vector<std::size_t> counts = {9 * 6, 10 * 7, 4 * 6 * 5, 8 * 6, 4 * 11, 14 * 14 - 36};
  for (std::size_t i = 0; i < counts.size(); ++i)
    EXPECT_EQ(target_points(some()[i]).size(), counts[i]) << to_text(some()[i]);
}

TEST(CalibrationTarget, NumbersRunAsInTheProgramsThatDetectThem) {
  // OpenCV from the upper left, Kalibr from the lower left.
  const auto chess = target_points(some()[0]);
  EXPECT_LT(chess[0].at_m.x(), chess[1].at_m.x());
  EXPECT_GT(chess[0].at_m.y(), chess[9].at_m.y());
  const auto april = target_points(some()[2]);
  EXPECT_NEAR(april[1].at_m.x() - april[0].at_m.x(), 0.1 / 3, 1e-15);        // along a tag
  EXPECT_NEAR(april[2].at_m.x() - april[1].at_m.x(), 0.3 * 0.1 / 3, 1e-15);  // to the next
  EXPECT_GT(april[12].at_m.y(), april[0].at_m.y());
  const auto discs = target_points(some()[4]);
  EXPECT_NEAR(discs[4].at_m.x() - discs[0].at_m.x(), 0.018, 1e-15);  // half a step to the right
}

std::string refusal(const std::string& text) {
  try {
    target_from_text(text);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

TEST(CalibrationTarget, RefusesTextsByName) {
  EXPECT_THAT(refusal(""), HasSubstr("is not one of chessboard"));
  EXPECT_THAT(refusal("chess columns=3"), HasSubstr("\"chess\""));
  EXPECT_THAT(refusal("chessboard columns=ten"), HasSubstr("columns = ten"));
  EXPECT_THAT(refusal("chessboard columns=1e3"), HasSubstr("columns"));
  EXPECT_THAT(refusal("chessboard pitch_m=nan"), HasSubstr("pitch_m"));
  EXPECT_THAT(refusal("chessboard pitch_m"), HasSubstr("pitch_m"));
  EXPECT_THAT(refusal("chessboard size=3"), HasSubstr("size"));
  EXPECT_THAT(refusal("charuco columns=5 rows=5 mark_share=0.7"), HasSubstr("dictionary"));
  EXPECT_THAT(refusal("circles mark_share=0.6"), HasSubstr("mark_share"));
  EXPECT_THAT(refusal("seed_board columns=9 rows=8"), HasSubstr("rows"));
  EXPECT_THAT(refusal(std::string(201, 'c')), HasSubstr("200"));
}

}  // namespace
}  // namespace cousin
