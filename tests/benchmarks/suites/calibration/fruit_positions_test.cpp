#include "benchmarks/suites/calibration/fruit_positions.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <string>

namespace cousin {
namespace {

const Eigen::Vector3d& at(const FruitPosition& position, PositionStep step) {
  return position.step_m[static_cast<std::size_t>(step)];
}

TEST(FruitPositions, EachStepAddsItsOwnErrorAlone) {
  PositionsConfig config;
  config.points = 3;
  config.tape_m = 0;
  config.out_of_yaw_px = 0.45;
  const std::vector<FruitPosition> positions = measure_positions(config, 3, 0);
  ASSERT_EQ(positions.size(), 3U);
  for (const FruitPosition& p : positions) {
    EXPECT_EQ(at(p, PositionStep::tape), at(p, PositionStep::held));
    const double z = at(p, PositionStep::box).z();
    EXPECT_GT(z, 0.29);
    EXPECT_LT(z, 0.62);
    // The box's middle is on the fruit, and nowhere nearer than its nearest point.
    EXPECT_GE(z, at(p, PositionStep::held).z());
    EXPECT_LT(z, at(p, PositionStep::held).z() + 0.03);
    // Aligned depth is another pixel's, in whole millimetres: half of one, and the fruit's slope
    // over a pixel of 1.5 mm at most.
    EXPECT_NEAR(at(p, PositionStep::aligned).z(), z, 0.003);
    // The yaw's disparity is Z^2 d / (f B) whichever way it goes; the unit's own focal length,
    // baseline and yaw may add .3 % (2.5 sigma each) and rounding 1 mm.
    const double bias_m =
        std::abs(at(p, PositionStep::unit).z() - at(p, PositionStep::aligned).z());
    EXPECT_NEAR(bias_m, z * z * 0.45 / (384 * 0.095), 0.003 * z + 0.001);
    ASSERT_TRUE(p.has_depth);
    // The noise is a tenth of a pixel of disparity; allow five.
    EXPECT_NEAR(at(p, PositionStep::measured).z(), at(p, PositionStep::unit).z(),
                5 * 0.1 * z * z / (384 * 0.095) + 0.001);
    // A lens moves points sideways only.
    EXPECT_EQ(at(p, PositionStep::pinhole).z(), at(p, PositionStep::measured).z());
    EXPECT_LT((at(p, PositionStep::calibrated) - at(p, PositionStep::measured)).norm(), 0.01 * z);
  }
  const std::vector<FruitPosition> again = measure_positions(config, 3, 0);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    for (std::size_t s = 0; s < kPositionSteps; ++s)
      EXPECT_EQ(positions[i].step_m[s], again[i].step_m[s]);
  }
}

FruitPosition made_up(const Eigen::Vector3d& truth_m, const Eigen::Vector3d& measured_m) {
  FruitPosition p;
  p.step_m.fill(truth_m);
  p.step_m[static_cast<std::size_t>(PositionStep::measured)] = measured_m;
  p.step_m[static_cast<std::size_t>(PositionStep::calibrated)] = measured_m;
  p.step_m[static_cast<std::size_t>(PositionStep::pinhole)] = measured_m;
  const Camera lens = strawberry_paper_lens();
  p.box_px = {lens.cx_px + lens.fx_px * measured_m.x() / measured_m.z(),
              lens.cy_px + lens.fy_px * measured_m.y() / measured_m.z()};
  p.has_depth = true;
  return p;
}

double value_of(const std::vector<ScoreRow>& rows, const std::string& case_name,
                const std::string& method, const std::string& metric) {
  for (const ScoreRow& row : rows) {
    if (row.case_name == case_name && row.method == method && row.metric == metric)
      return row.value;
  }
  ADD_FAILURE() << case_name << " / " << method << " / " << metric;
  return std::nan("");
}

TEST(PositionRows, AKnownOffsetScoresItselfWhereItIsMade) {
  std::vector<std::vector<FruitPosition>> runs(2);
  for (int k = 0; k < 12; ++k) {
    const Eigen::Vector3d truth(0.01 * (k - 6), 0.02, 0.31 + 0.024 * k);
    runs[static_cast<std::size_t>(k % 2)].push_back(
        made_up(truth, truth + Eigen::Vector3d(0.001, -0.002, 0.003)));
  }
  const auto rows = position_rows(runs, "unit", 1);
  EXPECT_NEAR(value_of(rows, "unit, 0.3 to 0.6 m", "as the paper", "x.rmse"), 0.001, 1e-12);
  EXPECT_NEAR(value_of(rows, "unit, 0.3 to 0.6 m", "as the paper", "y.mae"), 0.002, 1e-12);
  EXPECT_NEAR(value_of(rows, "unit, 0.4 to 0.5 m", "as the paper", "z.bias"), 0.003, 1e-12);
  EXPECT_NEAR(value_of(rows, "unit, 0.3 to 0.6 m", "share of the stereo noise", "z.rmse"), 0.003,
              1e-12);
  EXPECT_EQ(value_of(rows, "unit, 0.3 to 0.6 m", "share of the tape", "z.rmse"), 0);
  EXPECT_EQ(value_of(rows, "unit, 0.5 to 0.6 m", "share of the calibration", "x.rmse"), 0);
}

TEST(PositionRows, TheTapeAtThePointUnderTheBoxLeavesThatShareOut) {
  std::vector<std::vector<FruitPosition>> runs(1);
  for (int k = 0; k < 12; ++k) {
    const Eigen::Vector3d truth(0.01 * (k - 6), 0.02, 0.31 + 0.024 * k);
    FruitPosition p = made_up(truth, truth + Eigen::Vector3d(0.001, -0.002, 0.003));
    // Held 1 cm below the box's centre, and read 1 mm off.
    for (const PositionStep step : {PositionStep::tape, PositionStep::held})
      p.step_m[static_cast<std::size_t>(step)].y() += 0.01;
    p.step_m[static_cast<std::size_t>(PositionStep::tape)].x() += 0.001;
    runs[0].push_back(p);
  }
  const auto rows = position_rows(runs, "unit", 1);
  const std::string all = "unit, 0.3 to 0.6 m";
  EXPECT_NEAR(value_of(rows, all, "as the paper", "y.rmse"), 0.012, 1e-12);
  const std::string held = kHeldUnderBox;
  EXPECT_NEAR(value_of(rows, all, held, "y.rmse"), 0.002, 1e-12);
  EXPECT_NEAR(value_of(rows, all, held, "x.rmse"), 0, 1e-12);
  EXPECT_NEAR(value_of(rows, all, held, "z.rmse"), 0.003, 1e-12);
}

TEST(PositionRows, TurnedAxesTakeUpARotationAndNothingElse) {
  std::vector<std::vector<FruitPosition>> runs(1);
  const Eigen::AngleAxisd turn(0.06, Eigen::Vector3d::UnitX());
  for (int k = 0; k < 12; ++k) {
    const Eigen::Vector3d truth(0.02 * (k - 6), 0.03 * (k % 3 - 1), 0.31 + 0.024 * k);
    FruitPosition p = made_up(truth, turn * truth);
    runs[0].push_back(p);
  }
  const auto rows = position_rows(runs, "unit", 1);
  const std::string all = "unit, 0.3 to 0.6 m";
  EXPECT_GT(value_of(rows, all, "the paper's lens, equation 4", "y.rmse"), 0.02);
  EXPECT_LT(value_of(rows, all, "the paper's lens, equation 4, axes turned to fit", "y.rmse"),
            1e-9);
}

TEST(PositionRows, PublishedErrorsOfZAreNearlyAllBias) {
  double z = 0;
  for (const ScoreRow& row : published_position_rows()) {
    if (row.case_name == "published, 0.5 to 0.6 m" && row.metric.starts_with("z.mae over"))
      z = row.value;
  }
  EXPECT_NEAR(z, 0.38 / 0.39, 1e-12);
}

}  // namespace
}  // namespace cousin
