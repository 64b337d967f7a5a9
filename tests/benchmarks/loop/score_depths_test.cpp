#include "benchmarks/loop/score_depths.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace cousin {
namespace {

constexpr float kNoDepth = std::numeric_limits<float>::quiet_NaN();

/// Two views of a wall 1.5 m away by a pair 0.1 m apart: 400 px of focal length, 26.7 px.
SceneTruth wall() {
  SceneTruth truth;
  SensorViews right{"rgb_right", {}, {}};
  for (int frame = 0; frame < 2; ++frame) {
    TrueView view;
    view.frame = frame;
    view.camera.width_px = 10;
    view.camera.height_px = 10;
    view.camera.fx_px = view.camera.fy_px = 400;
    truth.views.push_back(view);
    view.camera_from_world.translation_m.x() = -0.1;
    right.views.push_back(view);
    TruthImages images;
    images.depth_m = Image<float>(10, 10, 1.5F);
    images.depth_m(0, 0) = std::numeric_limits<float>::infinity();  // the sky
    truth.images.push_back(std::move(images));
  }
  truth.other_sensors = {right};
  return truth;
}

FrameDepth depth(int frame, float depth_m) {
  return {frame, Image<float>(10, 10, depth_m), Image<float>(10, 10, 0.01F), {}};
}

double value(const std::vector<ScoreRow>& rows, const std::string& metric,
             const std::string& name = "all") {
  for (const ScoreRow& row : rows) {
    if (row.metric == metric && row.case_name == name) return row.value;
  }
  ADD_FAILURE() << "no row " << metric;
  return ScoreRow::kNone;
}

TEST(ScoreDepths, ErrorsAreOfWhatIsMeasuredAndSharesOfWhatIsThere) {
  Estimate estimate;
  estimate.depths = {depth(0, 1.515F), {.frame = 1}};
  estimate.depths[0].depth_m(5, 5) = kNoDepth;
  const auto rows = score_depths(wall(), estimate, {});
  EXPECT_EQ(value(rows, "depth.frames"), 0.5);
  EXPECT_NEAR(value(rows, "depth.measured"), 98.0 / 198, 1e-12);  // the sky is nowhere
  EXPECT_NEAR(value(rows, "depth.error"), 0.015, 1e-6);
  EXPECT_NEAR(value(rows, "depth.error_relative"), 0.01, 1e-6);
  EXPECT_NEAR(value(rows, "depth.bias"), 0.015, 1e-6);
  EXPECT_EQ(value(rows, "depth.bad_05_px"), 0);  // 0.26 px
  EXPECT_EQ(value(rows, "depth.coverage_95"), 1);
  EXPECT_NEAR(value(rows, "depth.normalised"), 1.5, 1e-4);
  EXPECT_NEAR(value(rows, "depth.error", "1 to 2 m"), 0.015, 1e-6);
}

TEST(ScoreDepths, BadPixelsAreOfDisparity) {
  Estimate estimate;
  estimate.depths = {depth(0, 1.6F), depth(1, 1.5F)};  // 1.67 px off, and right
  const auto rows = score_depths(wall(), estimate, {});
  EXPECT_EQ(value(rows, "depth.bad_05_px"), 0.5);
  EXPECT_EQ(value(rows, "depth.bad_1_px"), 0.5);
  EXPECT_EQ(value(rows, "depth.bad_2_px"), 0);
  SceneTruth one_eye = wall();
  one_eye.other_sensors.clear();
  for (const ScoreRow& row : score_depths(one_eye, estimate, {}))
    EXPECT_THAT(row.metric, testing::Not(testing::HasSubstr("bad")));
}

TEST(ScoreDepths, ADepthSensorIsNoOtherEyeAndTheSkyIsNoSurface) {
  SceneTruth truth = wall();
  truth.other_sensors[0].sensor = "depth";
  for (TruthImages& images : truth.images)
    images.depth_m = Image<float>(10, 10, std::numeric_limits<float>::infinity());
  Estimate estimate;
  estimate.depths = {depth(0, 1.5F)};
  for (const ScoreRow& row : score_depths(truth, estimate, {})) {
    EXPECT_THAT(row.metric, testing::Not(testing::HasSubstr("bad")));
    EXPECT_FALSE(std::isnan(row.value)) << row.metric;
  }
}

TEST(ScoreDepths, WhatIsOfAnotherCaptureIsRefused) {
  Estimate estimate;
  estimate.depths = {depth(3, 1)};
  EXPECT_THROW(score_depths(wall(), estimate, {}), std::invalid_argument);
  estimate.depths = {depth(0, 1)};
  estimate.depths[0].depth_m = Image<float>(4, 4, 1.0F);
  EXPECT_THROW(score_depths(wall(), estimate, {}), std::invalid_argument);
  // Somebody's zero is no depth, and may not count as one.
  for (const float none : {0.0F, -1.0F, std::numeric_limits<float>::infinity()}) {
    estimate.depths = {depth(0, 1)};
    estimate.depths[0].depth_m(3, 3) = none;
    EXPECT_THROW(score_depths(wall(), estimate, {}), std::invalid_argument) << none;
  }
  SceneTruth blind = wall();
  blind.images.clear();
  EXPECT_THROW(score_depths(blind, {}, {}), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
