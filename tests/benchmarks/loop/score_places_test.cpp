// Errors of places in the camera, from rows whose errors are known.
#include "benchmarks/loop/score_places.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace cousin {
namespace {

constexpr std::string_view kTraits[] = {"cut_x", "cut_y", "cut_z", "axis_x", "axis_y", "axis_z"};

/// Rows of one box: the cut is off by so much aside and along the line of sight, the axis is
/// turned.
void add_box(double aside_m, double along_m, double turned_rad, bool is_measured,
             std::vector<SpecimenRow>& rows) {
  const double truth[] = {0, 0, 0.5, 0, -1, 0};
  const double measured[] = {aside_m, 0, 0.5 + along_m, std::sin(turned_rad), -std::cos(turned_rad),
                             0};
  for (std::size_t k = 0; k < 6; ++k) {
    SpecimenRow row;
    row.trait = kTraits[k];
    row.truth = truth[k];
    row.measured = measured[k];
    row.status = is_measured ? ScoreStatus::ok : ScoreStatus::not_solved;
    rows.push_back(row);
  }
}

double value_of(const std::vector<ScoreRow>& rows, const std::string& metric) {
  for (const ScoreRow& row : rows) {
    if (row.metric == metric) return row.value;
  }
  return ScoreRow::kNone;
}

TEST(ScorePlaces, MediansSharesAndAngles) {
  std::vector<SpecimenRow> rows;
  add_box(0.001, 0, 0.05, true, rows);
  add_box(0.003, 0.004, 0.1, true, rows);
  add_box(0.006, 0.0079, 0.3, true, rows);
  add_box(0, 0, 0, false, rows);  // counts in shares as not reached
  std::vector<ScoreRow> scores;
  add_place_rows(rows, kTraits, {}, scores);
  EXPECT_NEAR(value_of(scores, "cut.error_3d"), 0.005, 1e-12);
  EXPECT_NEAR(value_of(scores, "cut.error_lateral"), 0.003, 1e-12);
  EXPECT_NEAR(value_of(scores, "cut.rmse_3d"), std::sqrt((1 + 25 + 36 + 7.9 * 7.9) / 3) * 1e-3,
              1e-12);
  EXPECT_DOUBLE_EQ(value_of(scores, "cut.within_2_mm"), 0.25);
  EXPECT_DOUBLE_EQ(value_of(scores, "cut.within_10_mm"), 0.75);
  EXPECT_NEAR(value_of(scores, "axis.error_angle"), 0.1, 1e-9);
  EXPECT_DOUBLE_EQ(value_of(scores, "axis.within_10_deg"), 0.5);
  EXPECT_TRUE(std::isnan(value_of(scores, "centre.error_3d")));
}

TEST(ScorePlaces, OnlyPlacesArePlaces) {
  EXPECT_TRUE(is_of_place("cut_x"));
  EXPECT_TRUE(is_of_place("axis_z"));
  EXPECT_TRUE(is_of_place("approach_y"));
  for (const char* other : {"point_x", "length", "x", "", "cut", "cut_q", "cut_w", "red_share"})
    EXPECT_FALSE(is_of_place(other)) << other;
  std::vector<ScoreRow> scores;
  add_place_rows({}, kTraits, {}, scores);
  add_place_rows({}, {}, {}, scores);
  EXPECT_TRUE(scores.empty());
}

}  // namespace
}  // namespace cousin
