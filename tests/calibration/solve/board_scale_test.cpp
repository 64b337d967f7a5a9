#include "calibration/solve/board_scale.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "sim/types/rng.h"

namespace cousin {
namespace {

std::vector<Eigen::Vector3d> board() {
  std::vector<Eigen::Vector3d> points;
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 9; ++c) points.emplace_back(0.006 * c, 0.006 * r, 0);
  }
  return points;
}

constexpr double kPerUnit_m = 0.0371;

/// Corners in a model that is turned, moved and of another unit, with errors of `sigma` units.
std::vector<ModelCorner> in_model(double sigma, Rng rng) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, -1).normalized()));
  std::vector<ModelCorner> corners;
  const std::vector<Eigen::Vector3d> points = board();
  for (std::size_t i = 0; i < points.size(); i += 2) {
    const Eigen::Vector3d off(normal(rng), normal(rng), normal(rng));
    corners.push_back({static_cast<int>(i),
                       turn * points[i] / kPerUnit_m + Eigen::Vector3d(3, -7, 20) + sigma * off});
  }
  return corners;
}

TEST(BoardScale, IsTheTrueSideOverTheModels) {
  const BoardScale scale = scale_from_board(in_model(0, Rng(1)), board());
  ASSERT_EQ(scale.status, CalibrationStatus::ok) << scale.reason;
  EXPECT_NEAR(scale.m_per_unit, kPerUnit_m, 1e-12);
  EXPECT_LT(scale.rms_m, 1e-12);
}

TEST(BoardScale, IsOffAsOftenAsItsDeviationSays) {
  double squares = 0;
  constexpr int kDraws = 200;
  for (std::uint64_t seed = 0; seed < kDraws; ++seed) {
    const BoardScale scale = scale_from_board(in_model(0.01, Rng(seed)), board());
    const double off = (scale.m_per_unit - kPerUnit_m) / scale.sigma;
    squares += off * off;
    EXPECT_NEAR(scale.rms_m, 0.01 * kPerUnit_m, 0.4 * 0.01 * kPerUnit_m);
  }
  // A chi-square of 200 over 200 has a deviation of 0.1; four.
  EXPECT_NEAR(squares / kDraws, 1, 0.4);
}

TEST(BoardScale, WhatGivesNoScaleIsRefused) {
  const std::vector<Eigen::Vector3d> points = board();
  EXPECT_EQ(scale_from_board({{0, {0, 0, 0}}, {1, {1, 0, 0}}, {9, {0, 1, 0}}}, points).status,
            CalibrationStatus::not_determined);
  std::vector<ModelCorner> line;
  for (int i = 0; i < 6; ++i) line.push_back({i, {1.0 * i, 0, 0}});
  const BoardScale open = scale_from_board(line, points);
  EXPECT_EQ(open.status, CalibrationStatus::not_determined);
  EXPECT_NE(open.reason.find("line"), std::string::npos);
  line[1].id = 0;
  EXPECT_EQ(scale_from_board(line, points).status, CalibrationStatus::bad_input);
  line[1].id = 54;
  EXPECT_EQ(scale_from_board(line, points).status, CalibrationStatus::bad_input);
  line[1] = {1, {std::nan(""), 0, 0}};
  EXPECT_EQ(scale_from_board(line, points).status, CalibrationStatus::bad_input);
}

}  // namespace
}  // namespace cousin
