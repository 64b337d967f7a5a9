#include "calibration/bundle/bundle_frame.h"

#include <gtest/gtest.h>

#include "tests/calibration/bundle/plant_capture.h"

namespace cousin {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

TEST(BundleFrame, OfPointsOnALineATurnIsOpen) {
  Eigen::Matrix3Xd points(3, 4);
  for (int i = 0; i < 4; ++i) points.col(i) = Vector3d(1, 2, 3) + i * Vector3d(0.1, 0.2, -0.1);
  EXPECT_TRUE(are_on_a_line(points, 1e-6));
  EXPECT_TRUE(are_on_a_line(points.leftCols(2), 1e-6));
  points.col(1).x() += 1e-3;
  EXPECT_TRUE(are_on_a_line(points, 1e-2));
  EXPECT_FALSE(are_on_a_line(points, 1e-3));
}

#ifndef COUSIN_NO_CERES
TEST(BundleFrame, SolvesTheSameInAnyUnitFarAwayAndTurned) {
  const PlantCapture capture = plant_capture(16, 80, 0.3, false, 2);
  const BundleAdjustmentInput start = disturbed(capture.truth, 2);
  const auto reference = adjust_bundle(start);
  ASSERT_EQ(reference.status, CalibrationStatus::ok) << reference.reason;
  for (const double scale : {1e-3, 1.0, 1e3, 1e6}) {
    for (const double far : {0.0, 1e3}) {  // in units of the scene
      const Eigen::Quaterniond turn = exp_rotation({0.3, -1.1, 0.7});
      const Vector3d shift = scale * far * Vector3d(1, -2, 0.5);
      BundleAdjustmentInput moved = start;
      for (Vector3d& p : moved.points_in_world_m) p = scale * (turn * p) + shift;
      for (Pose& pose : moved.camera_from_world) {
        pose.rotation = pose.rotation * turn.conjugate();
        pose.translation_m = scale * pose.translation_m - pose.rotation * shift;
      }
      const auto result = adjust_bundle(moved);
      ASSERT_EQ(result.status, CalibrationStatus::ok) << scale << " " << far << result.reason;
      // Numbers of 1e3 scene sizes keep 13 digits of the scene.
      EXPECT_NEAR(result.lenses[0].fx_px, reference.lenses[0].fx_px, 1e-6) << scale << " " << far;
      EXPECT_NEAR(result.cost_px2, reference.cost_px2, 1e-8 * reference.cost_px2);
      EXPECT_NEAR(result.covariance(0, 0), reference.covariance(0, 0),
                  1e-5 * reference.covariance(0, 0));
      for (std::size_t p = 0; p < start.points_in_world_m.size(); ++p) {
        const Vector3d back = turn.conjugate() * (result.points_in_world_m[p] - shift) / scale;
        EXPECT_LT((back - reference.points_in_world_m[p]).norm(), 1e-8) << scale << " " << far;
      }
    }
  }
}

TEST(BundleFrame, ABoardsCornersGiveMetresAndTheFrame) {
  PlantCapture capture = plant_capture(16, 80, 0.2, false, 3);
  BundleAdjustmentInput start = disturbed(capture.truth, 3);
  for (int p = 0; p < 12; ++p)
    start.known_points.push_back({p, capture.truth.points_in_world_m[static_cast<std::size_t>(p)]});
  // The start is half as large as the world.
  for (Vector3d& point : start.points_in_world_m) point *= 0.5;
  for (Pose& pose : start.camera_from_world) pose.translation_m *= 0.5;
  const auto result = adjust_bundle(start);
  ASSERT_EQ(result.status, CalibrationStatus::ok) << result.reason;
  EXPECT_EQ(result.gauge, BundleGauge::metric);
  for (std::size_t p = 0; p < 80; ++p) {
    EXPECT_LT((result.points_in_world_m[p] - capture.truth.points_in_world_m[p]).norm(), 5e-4);
  }
}

// Centres on a rail leave a turn about it open, which the cameras' own turns close.
TEST(BundleFrame, CamerasOnARailKeepTheirFrame) {
  for (const int images : {2, 3, 7}) {
    PlantCapture rail = plant_capture(images, 60, 0.1, false, 8);
    BundleAdjustmentInput& t = rail.truth;
    t.observations.clear();
    const Lens lens(t.lenses[0]);
    Rng rng = Rng(8).fork("rail");
    for (int i = 0; i < images; ++i) {
      const Vector3d eye =
          Vector3d(0, -0.4, 0.1) + (0.2 * i / (images - 1) - 0.1) * Vector3d(1, 0.31, 0.17);
      t.camera_from_world[static_cast<std::size_t>(i)] = look_at(eye, Vector3d(0, 0, 0.05));
      for (int p = 0; p < 60; ++p) {
        const auto pixel = lens.project(t.camera_from_world[static_cast<std::size_t>(i)] *
                                        t.points_in_world_m[static_cast<std::size_t>(p)]);
        if (!pixel) continue;
        t.observations.push_back(
            {i, p, *pixel + Vector2d(0.1 * normal(rng), 0.1 * normal(rng)), 1});
      }
    }
    BundleAdjustmentInput start = t;  // the right turns and centres, points a little off
    for (Vector3d& point : start.points_in_world_m)
      point += 0.003 * Vector3d(normal(rng), normal(rng), normal(rng));
    BundleAdjustmentConfig fixed;
    fixed.fixed = {"lens"};
    const auto result = adjust_bundle(start, fixed);
    ASSERT_EQ(result.status, CalibrationStatus::ok) << images << result.reason;
    for (int i = 0; i < images; ++i) {
      const auto at = static_cast<std::size_t>(i);
      EXPECT_LT(
          result.camera_from_world[at].rotation.angularDistance(t.camera_from_world[at].rotation),
          2e-3)
          << images;
    }
  }
}

TEST(BundleFrame, ADistanceGivesTheScale) {
  PlantCapture capture = plant_capture(16, 80, 0.2, false, 4);
  BundleAdjustmentInput start = disturbed(capture.truth, 4);
  const auto& truth = capture.truth.points_in_world_m;
  start.known_distances = {{0, 1, 2 * (truth[0] - truth[1]).norm(), 1e-6}};
  const auto result = adjust_bundle(start);
  ASSERT_EQ(result.status, CalibrationStatus::ok) << result.reason;
  EXPECT_EQ(result.gauge, BundleGauge::rigid);
  const double ratio = (result.points_in_world_m[2] - result.points_in_world_m[3]).norm() /
                       (truth[2] - truth[3]).norm();
  EXPECT_NEAR(ratio, 2, 0.01);
}
#endif

}  // namespace
}  // namespace cousin
