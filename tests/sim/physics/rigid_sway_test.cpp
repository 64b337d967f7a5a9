#include "sim/physics/rigid_sway.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace cousin {
namespace {

WindField steady(double speed_m_s) {
  WindField wind;
  wind.mean_m_s = {speed_m_s, 0, 0};
  return wind;
}

/// Lean of a plant from upright.
double lean_rad(const TimedPose& pose) {
  const Eigen::Vector3d up = pose.world_from_object.rotation * Eigen::Vector3d::UnitZ();
  return std::acos(std::min(1.0, up.z()));
}

TEST(RigidSway, ASteadyWindLeansThePlantDownwindByItsDrag) {
  RigidSwayConfig config;
  config.damping = 0.5;
  config.frequency_spread = 0;
  Pose foot;
  foot.translation_m = {3, 4, 0};
  const auto motion = rigid_sway(config, steady(5), foot, {0, 0, 1}, {0}, Rng(1));
  // After 8 periods of zeta = 0.5 the swing is down to exp(-8 pi) of its first.
  EXPECT_NEAR(lean_rad(motion.front()), config.lean_rad_s2_m2 * 25, 1e-9);
  const Pose& pose = motion.front().world_from_object;
  EXPECT_EQ(pose.translation_m, foot.translation_m);  // about its foot
  EXPECT_GT((pose.rotation * Eigen::Vector3d::UnitZ()).x(), 0);
  EXPECT_NEAR((pose.rotation * Eigen::Vector3d::UnitZ()).y(), 0, 1e-15);
}

TEST(RigidSway, SwingsAtItsFrequency) {
  RigidSwayConfig config;
  config.damping = 0.001;
  config.frequency_hz = 2;
  config.frequency_spread = 0;
  const auto motion = rigid_sway(config, steady(5), {}, {0, 0, 1}, {0, 0.5, 1, 1.5}, Rng(1));
  const double rest_rad = config.lean_rad_s2_m2 * 25;
  std::vector<double> crossings_s;
  for (std::size_t i = 1; i < motion.size(); ++i) {
    const double before = lean_rad(motion[i - 1]) - rest_rad, now = lean_rad(motion[i]) - rest_rad;
    if (before < 0 && now >= 0) crossings_s.push_back(motion[i].time_s);
  }
  ASSERT_GE(crossings_s.size(), 3U);
  const double period_s =
      (crossings_s.back() - crossings_s.front()) / static_cast<double>(crossings_s.size() - 1);
  // Crossings are known to a step of 5 ms, of 0.5 s and more between the first and the last.
  EXPECT_NEAR(period_s, 0.5, 0.005);
}

TEST(RigidSway, CoversTheTimesOfTheViewsInOrder) {
  const auto motion = rigid_sway({}, steady(3), {}, {0, 0, 1}, {0, 1, 30}, Rng(2));
  for (std::size_t i = 1; i < motion.size(); ++i) EXPECT_LT(motion[i - 1].time_s, motion[i].time_s);
  EXPECT_LE(motion.front().time_s, -0.09);
  EXPECT_GE(motion.back().time_s, 30.5);
  for (const double time_s : {0.0, 1.0, 30.0}) {
    int near = 0;
    for (const TimedPose& p : motion) near += std::abs(p.time_s - time_s) < 0.09;
    EXPECT_GE(near, 34) << time_s;  // 0.18 s in steps of 5 ms
  }
  EXPECT_THROW(rigid_sway({}, steady(3), {}, {0, 0, 1}, {1, 0}, Rng(2)), std::invalid_argument);
}

TEST(RigidSway, StillAirChangesNothing) {
  Scene scene;
  scene.instances.resize(2);
  scene.instances[1].is_specimen = true;
  scene.views.resize(3);
  sway_specimens(scene, {}, {}, 0.5, Rng(1));
  EXPECT_TRUE(scene.instances[1].motion.empty());
  WindConfig wind;
  wind.mean_speed_m_s = 2;
  sway_specimens(scene, wind, {}, 0.5, Rng(1));
  EXPECT_FALSE(scene.instances[1].motion.empty());
  EXPECT_TRUE(scene.instances[0].motion.empty());  // the setting stands
}

}  // namespace
}  // namespace cousin
