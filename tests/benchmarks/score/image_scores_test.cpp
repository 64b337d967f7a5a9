#include "benchmarks/score/image_scores.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "sim/geometry/similarity.h"

namespace cousin {
namespace {

TEST(MaskIou, CountsPixels) {
  Image<std::uint8_t> a(10, 10), b(10, 10);
  for (int y = 0; y < 10; ++y) {
    for (int x = 0; x < 6; ++x) a(x, y) = 255;
    for (int x = 3; x < 10; ++x) b(x, y) = 1;
  }
  EXPECT_DOUBLE_EQ(mask_iou(a, b), 0.3);
  EXPECT_EQ(mask_iou(a, a), 1);
  EXPECT_TRUE(std::isnan(mask_iou(Image<std::uint8_t>(4, 4), Image<std::uint8_t>(4, 4))));
  EXPECT_THROW(mask_iou(a, Image<std::uint8_t>(4, 4)), std::invalid_argument);
}

TEST(ScoreDepth, AKnownOffsetScoresItself) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  Image<float> truth(10, 10, 0.5F);
  Image<float> estimate(10, 10, 0.75F);
  truth(0, 0) = nan;     // no surface: whatever is claimed there does not count
  estimate(1, 0) = nan;  // a hole
  const DepthScore score = score_depth(estimate, truth, 0.1);
  EXPECT_EQ(score.truth_pixels, 99);
  EXPECT_DOUBLE_EQ(score.filled, 98.0 / 99);
  EXPECT_DOUBLE_EQ(score.bias_m, 0.25);
  EXPECT_DOUBLE_EQ(score.rmse_m, 0.25);
  EXPECT_DOUBLE_EQ(score.p95_abs_m, 0.25);
  EXPECT_EQ(score.bad_share, 1);

  Image<std::uint8_t> mask(10, 10);
  mask(5, 5) = 1;
  EXPECT_EQ(score_depth(estimate, truth, 0.1, mask).truth_pixels, 1);
  EXPECT_TRUE(std::isnan(score_depth(Image<float>(10, 10, nan), truth, 0.1).rmse_m));
  EXPECT_THROW(score_depth(Image<float>(9, 10), truth, 0.1), std::invalid_argument);
  EXPECT_THROW(score_depth(estimate, truth, 0.1, Image<std::uint8_t>(3, 3)), std::invalid_argument);
}

TEST(ScorePoses, AKnownShiftAndTurnScoreThemselves) {
  const Pose truth = look_at({0.3, 0.1, 0.4}, {0, 0, 0});
  FramePose estimate;
  estimate.status = PoseStatus::ok;
  estimate.camera.fx_px = 1010;
  // Turn about the camera's centre by 0.01 rad, then move the centre by 2 mm.
  const Pose turn{Eigen::Quaterniond(Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitY())),
                  {0, 0.002, 0}};
  estimate.camera_from_world = turn * truth;
  FramePose lost;
  Camera camera;
  camera.fx_px = 1000;
  const PoseScore score = score_poses({estimate, lost}, std::vector<Pose>{truth, truth},
                                      std::vector<Camera>{camera, camera});
  EXPECT_EQ(score.views, 2);
  EXPECT_EQ(score.posed, 1);
  EXPECT_NEAR(score.centre_rms_m, 0.002, 1e-12);
  EXPECT_NEAR(score.rotation_rms_rad, 0.01, 1e-12);
  EXPECT_NEAR(score.focal_rms, 0.01, 1e-12);
  EXPECT_THROW(score_poses({estimate}, {}), std::invalid_argument);
}

TEST(ScorePoses, NoPosedViewHasNoError) {
  const PoseScore score = score_poses({FramePose{}}, std::vector<Pose>{Pose{}});
  EXPECT_EQ(score.posed, 0);
  EXPECT_TRUE(std::isnan(score.centre_rms_m));
}

/// Cameras around the origin at 0.5 m, and the same in a world and unit of its own.
struct TwoWorlds {
  std::vector<Pose> truth;
  Poses estimate;
};
TwoWorlds two_worlds(double scale) {
  const WorldSimilarity other{
      scale, Eigen::Quaterniond(0.3, 0.1, -0.6, 0.5).normalized(), {4, -2, 1}};
  TwoWorlds worlds;
  for (int i = 0; i < 6; ++i) {
    const Eigen::Vector3d eye(std::cos(i), std::sin(i), 0.3 + 0.1 * (i % 2));
    worlds.truth.push_back(look_at(0.5 * eye.normalized(), {0, 0, 0}));
    worlds.estimate.push_back({.frame = i,
                               .status = PoseStatus::ok,
                               .camera_from_world = moved(worlds.truth.back(), other)});
  }
  return worlds;
}

TEST(ScorePoses, AnotherWorldAndUnitScoreNothingOnceAligned) {
  const TwoWorlds worlds = two_worlds(3.5);
  const PoseScore apart = score_poses(worlds.estimate, worlds.truth);
  EXPECT_GT(apart.centre_rms_m, 1);
  EXPECT_EQ(apart.scale, 1);
  const PoseScore score = score_poses(worlds.estimate, worlds.truth, {}, PoseAlignment::similarity);
  EXPECT_EQ(score.posed, 6);
  EXPECT_NEAR(score.scale, 1 / 3.5, 1e-12);
  EXPECT_NEAR(score.centre_rms_m, 0, 1e-12);
  EXPECT_NEAR(score.rotation_rms_rad, 0, 1e-7);  // acos near one loses half the digits
  EXPECT_NEAR(score.rotation_max_rad, 0, 1e-7);
}

TEST(ScorePoses, CentresAreAlsoAShareOfTheDistance) {
  TwoWorlds worlds = two_worlds(1);
  // All cameras look at the origin from 0.5 m; one of six is 6 mm off.
  for (std::size_t i = 0; i < 6; ++i) worlds.estimate[i].camera_from_world = worlds.truth[i];
  worlds.estimate[2].camera_from_world.translation_m.x() += 0.006;
  const PoseScore score = score_poses(worlds.estimate, worlds.truth);
  EXPECT_NEAR(score.centre_rms_m, 0.006 / std::sqrt(6), 1e-12);
  EXPECT_NEAR(score.centre_rms_share, 0.006 / std::sqrt(6) / 0.5, 1e-9);
  // Parallel views look at no point.
  std::vector<Pose> parallel(3);
  for (int i = 0; i < 3; ++i) parallel[static_cast<std::size_t>(i)].translation_m.x() = i;
  Poses same(3);
  for (std::size_t i = 0; i < 3; ++i) {
    same[i].status = PoseStatus::ok;
    same[i].camera_from_world = parallel[i];
  }
  EXPECT_TRUE(std::isnan(score_poses(same, parallel).centre_rms_share));
}

TEST(ScorePoses, TooFewViewsAreNotAligned) {
  TwoWorlds worlds = two_worlds(2);
  for (std::size_t i = 2; i < 6; ++i) worlds.estimate[i].status = PoseStatus::not_converged;
  const PoseScore score = score_poses(worlds.estimate, worlds.truth, {}, PoseAlignment::similarity);
  EXPECT_EQ(score.posed, 2);
  EXPECT_TRUE(std::isnan(score.centre_rms_m));
  EXPECT_TRUE(std::isnan(score.scale));
}

}  // namespace
}  // namespace cousin
