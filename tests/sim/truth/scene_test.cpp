#include "sim/truth/scene.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>
#include <stdexcept>

namespace cousin {
namespace {

Pose turned(double angle_rad, const Eigen::Vector3d& translation_m) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitZ())),
          translation_m};
}

/// At 1, 2 and 4 s: a quarter turn in the first second, half a turn back in the next two.
Instance moving() {
  Instance instance;
  instance.world_from_object = turned(1, {9, 9, 9});  // of a static one: must not be seen
  instance.motion = {{1, turned(0, {0, 0, 0})},
                     {2, turned(std::numbers::pi / 2, {0.1, 0, 0})},
                     {4, turned(-std::numbers::pi / 2 + 0.2, {0.1, 0.4, -0.2})}};
  return instance;
}

void expect_near(const Pose& pose, const Pose& expected) {
  EXPECT_LT((pose.translation_m - expected.translation_m).norm(), 1e-15);
  // The angle of a rotation near none is the root of the rounding error.
  EXPECT_LT(pose.rotation.angularDistance(expected.rotation), 1e-7);
}

TEST(WorldFromObject, IsTheSamplesPoseAtASample) {
  const Instance instance = moving();
  for (const TimedPose& sample : instance.motion) {
    expect_near(world_from_object(instance, sample.time_s), sample.world_from_object);
  }
}

TEST(WorldFromObject, BetweenSamplesMovesEvenlyAndTurnsTheShortWay) {
  const Instance instance = moving();
  expect_near(world_from_object(instance, 1.25), turned(std::numbers::pi / 8, {0.025, 0, 0}));
  expect_near(world_from_object(instance, 1.5), turned(std::numbers::pi / 4, {0.05, 0, 0}));
  // From 2 to 4 s: half of the way, and half of the turn of pi - 0.2.
  expect_near(world_from_object(instance, 3), turned(0.1, {0.1, 0.2, -0.1}));
  expect_near(world_from_object(instance, 3.5),
              turned(std::numbers::pi / 2 - 0.75 * (std::numbers::pi - 0.2), {0.1, 0.3, -0.15}));
}

TEST(WorldFromObject, IsHeldBeforeTheFirstSampleAndAfterTheLast) {
  const Instance instance = moving();
  for (const double time_s : {-1e9, 0.0, 0.999}) {
    expect_near(world_from_object(instance, time_s), instance.motion.front().world_from_object);
  }
  for (const double time_s : {4.001, 1e9}) {
    expect_near(world_from_object(instance, time_s), instance.motion.back().world_from_object);
  }
}

TEST(WorldFromObject, WithoutMotionIsTheStaticPoseAtAnyTime) {
  Instance instance = moving();
  instance.motion.clear();
  expect_near(world_from_object(instance, 0), instance.world_from_object);
  expect_near(world_from_object(instance, 3), instance.world_from_object);
  instance.motion = {{2, turned(0.3, {1, 2, 3})}};  // one sample: the same at any time too
  expect_near(world_from_object(instance, 0), turned(0.3, {1, 2, 3}));
  expect_near(world_from_object(instance, 5), turned(0.3, {1, 2, 3}));
}

TEST(MeshInWorld, FollowsTheMotion) {
  Scene scene;
  scene.models.resize(1);
  scene.models[0].mesh.vertices_m = {{1, 0, 0}};
  const Mesh mesh = mesh_in_world(scene, moving(), 2);
  EXPECT_LT((mesh.vertices_m[0] - Eigen::Vector3d(0.1, 1, 0)).norm(), 1e-15);
}

TEST(ValidateScene, NamesTheInstanceWhoseMotionIsNotSorted) {
  Scene scene;
  scene.models.resize(1);
  scene.materials.resize(1);
  scene.instances = {moving()};
  scene.instances[0].name = "pendulum";
  EXPECT_NO_THROW(validate(scene));
  scene.instances[0].motion[2].time_s = 2;  // twice the same time: no pose between
  try {
    validate(scene);
    FAIL() << "it was accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("pendulum"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("motion"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace cousin
