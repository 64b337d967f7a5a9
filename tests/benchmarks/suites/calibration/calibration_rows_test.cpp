#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "benchmarks/suites/calibration/calibration_causes.h"
#include "benchmarks/suites/calibration/cause_rows.h"
#include "benchmarks/suites/calibration/choice_rows.h"
#include "benchmarks/suites/calibration/exhibit_rows.h"
#include "benchmarks/suites/calibration/reprojection.h"

namespace cousin {
namespace {

TEST(Reprojection, DefinitionsOfTwoViewsAreThoseOfTheirFormulas) {
  CalibrationResult result;
  // View 0: distances 5 and 5; view 1: 13 alone, and one rejected.
  result.residuals = {{0, 0, {3, 4}, false},
                      {0, 1, {-4, 3}, false},
                      {1, 0, {5, 12}, false},
                      {1, 1, {100, 100}, true}};
  const ReprojectionErrors errors = reprojection_errors(result);
  EXPECT_NEAR(errors.rms_coordinate_px, std::sqrt(219.0 / 6), 1e-12);
  EXPECT_NEAR(errors.rms_point_px, std::sqrt(219.0 / 3), 1e-12);
  EXPECT_NEAR(errors.mean_distance_px, 23.0 / 3, 1e-12);
  EXPECT_NEAR(errors.tutorial_px, 0.5 * (std::sqrt(50.0) / 2 + 13), 1e-12);
}

TEST(Reprojection, OfNothingIsNoNumber) {
  EXPECT_TRUE(std::isnan(reprojection_errors({}).rms_point_px));
  EXPECT_TRUE(std::isnan(reprojection_errors({}).tutorial_px));
}

TEST(Choice, TheLowerCriterionIsTakenAndHeldAgainstTheBetterOfTwo) {
  // Right, right, wrong: twice as wrong as it need be.
  const CalibrationPair pairs[] = {{{1, 2}, {3, 4}}, {{2, 1}, {4, 3}}, {{1, 2}, {6, 3}}};
  const std::vector<ScoreRow> rows = choice_scores({}, pairs);
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_NEAR(rows[0].value, 2.0 / 3, 1e-12);
  EXPECT_LT(rows[0].ci_low, 2.0 / 3);
  EXPECT_GT(rows[0].ci_high, 2.0 / 3);
  EXPECT_NEAR(rows[1].value, 4.0 / 3, 1e-12);
  EXPECT_EQ(rows[2].value, 2);
}

#ifndef COUSIN_NO_CERES
TEST(Choice, EveryRowHasNumbersAndAShareIsOne) {
  for (const ScoreRow& row : choice_rows(3, true)) {
    EXPECT_TRUE(std::isfinite(row.value)) << row.case_name << ": " << row.metric;
    EXPECT_GT(row.n, 30) << row.case_name << ": " << row.metric;
    if (row.metric.ends_with("share")) {
      EXPECT_GE(row.value, 0);
      EXPECT_LE(row.value, 1);
    }
  }
}

CalibrationCause cause(const std::string& name) {
  for (const CalibrationCause& c : calibration_causes()) {
    if (c.name == name) return c;
  }
  throw std::logic_error(name);
}

TEST(Causes, NoiseAloneGivesReprojectionErrorsOfTheirDefinitions) {
  const auto outcomes = run_cause(cause("corner noise"), 0.1, 4, Rng(1));
  for (const CauseOutcome& o : outcomes) {
    // 30 views of 40 points: 2400 coordinates, 189 unknowns.
    const double sigma_px = 0.1 * std::sqrt(1 - 189 / 2400.0);
    // Relative standard error of sigma 1 / sqrt(2 * 2400) = 1.4 %; allow five.
    EXPECT_NEAR(o.rms_point_px, std::sqrt(2.0) * sigma_px, 0.1 * sigma_px);
    EXPECT_NEAR(o.mean_distance_px, std::sqrt(M_PI / 2) * sigma_px, 0.1 * sigma_px);
    EXPECT_NEAR(o.tutorial_px, std::sqrt(2.0 / 40) * sigma_px, 0.02 * sigma_px);
    EXPECT_FALSE(o.is_like_paper());
  }
}

TEST(Causes, AStretchedPrintIsAWrongRatioOfFocalLengthsNotAPrincipalPoint) {
  // Exact corners: what is found is the cause's alone.
  CalibrationCause stretched = cause("print stretched across");
  const auto set = stretched.set;
  stretched.set = [set](double v, CornerViewsConfig& c) {
    set(v, c);
    c.noise_px = 0;
    c.roll_rad = 0;
  };
  const CauseOutcome none = run_cause(stretched, 0, 1, Rng(2)).front();
  EXPECT_LT(none.projection_px, 1e-5);
  EXPECT_LT(none.rms_point_px, 1e-6);
  const CauseOutcome some = run_cause(stretched, 0.02, 1, Rng(2)).front();
  // 2 % of the distance from the middle: up to 6 px at the border, 3 px RMS over x.
  EXPECT_GT(some.projection_px, 1);
  EXPECT_LT(some.projection_px, 6);
}
#endif

TEST(Causes, FlawsMoveCornersAndSameBytesComeAgain) {
  for (const CalibrationCause& c : calibration_causes()) {
    ASSERT_FALSE(c.amounts.empty()) << c.name;
    CornerViewsConfig config = strawberry_views();
    c.set(c.amounts.back(), config);
    config.frames = 5;
    const CornerViews a = make_corner_views({strawberry_camera()}, {Pose{}}, config, Rng(5));
    const CornerViews b = make_corner_views({strawberry_camera()}, {Pose{}}, config, Rng(5));
    ASSERT_EQ(a.input.views.size(), 5U) << c.name;
    for (std::size_t v = 0; v < 5; ++v) {
      ASSERT_EQ(a.input.views[v].points.size(), b.input.views[v].points.size());
      for (std::size_t i = 0; i < a.input.views[v].points.size(); ++i)
        EXPECT_EQ(a.input.views[v].points[i].pixel_px, b.input.views[v].points[i].pixel_px);
    }
  }
}

#ifndef COUSIN_NO_CERES
TEST(Exhibits, HoldOnOtherSeeds) {
  int verdicts = 0;
  for (const ScoreRow& row : exhibit_rows(7, true)) {
    if (row.status == ScoreStatus::ok) continue;
    ++verdicts;
    EXPECT_EQ(row.status, ScoreStatus::pass)
        << row.case_name << ": " << row.metric << " = " << row.value;
  }
  EXPECT_GE(verdicts, 6);
}
#endif

}  // namespace
}  // namespace cousin
