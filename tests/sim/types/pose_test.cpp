#include "sim/types/pose.h"

#include <gtest/gtest.h>

#include <numbers>

namespace cousin {
namespace {

Pose some_pose() {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized())),
          {0.3, -2, 5}};
}

TEST(Pose, InverseCancels) {
  const Pose identity = some_pose() * inverse(some_pose());
  EXPECT_LT(identity.translation_m.norm(), 1e-14);
  EXPECT_LT(angle_rad(identity.rotation),
            1e-7);  // acos-like near zero: the root of the rounding error
}

TEST(Pose, MatrixRoundTrip) {
  const Pose back = pose_from_matrix(to_matrix(some_pose()));
  const Eigen::Vector3d x(0.1, 0.2, 0.3);
  EXPECT_LT((back * x - some_pose() * x).norm(), 1e-14);
}

TEST(Pose, RefusesAMatrixThatIsNotARotation) {
  Eigen::Matrix4d scaled = to_matrix(some_pose());
  scaled.topLeftCorner<3, 3>() *= 1.01;
  EXPECT_THROW(pose_from_matrix(scaled), std::invalid_argument);
  Eigen::Matrix4d mirrored = Eigen::Matrix4d::Identity();
  mirrored(0, 0) = -1;
  EXPECT_THROW(pose_from_matrix(mirrored), std::invalid_argument);
}

TEST(Pose, LookAtPutsTheTargetOnTheAxisAndUpInTheImage) {
  const Pose camera_from_world = look_at({1, 2, 3}, {0, 0, 0});
  const Eigen::Vector3d target = camera_from_world * Eigen::Vector3d::Zero();
  EXPECT_LT(target.head<2>().norm(), 1e-12);
  EXPECT_NEAR(target.z(), std::sqrt(14.0), 1e-12);
  EXPECT_LT((camera_from_world.rotation * Eigen::Vector3d::UnitZ()).y(), 0);  // image y points down
  EXPECT_LT((centre_in_world_m(camera_from_world) - Eigen::Vector3d(1, 2, 3)).norm(), 1e-12);
  EXPECT_THROW(look_at({0, 0, 1}, {0, 0, 0}), std::invalid_argument);
}

TEST(Pose, InterpolationReachesBothEndsAndHalvesTheAngle) {
  const Pose begin;
  const Pose end = some_pose();
  EXPECT_LT((interpolate(begin, end, 1).translation_m - end.translation_m).norm(), 1e-15);
  EXPECT_NEAR(angle_rad(interpolate(begin, end, 0.5).rotation), 0.35, 1e-12);
}

}  // namespace
}  // namespace cousin
