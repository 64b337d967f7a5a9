#include "sim/physics/settle.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "sim/geometry/measure.h"
#include "tests/sim/physics/solids.h"

namespace cousin {
namespace {

constexpr double kDensity = 1250;

Pose tilted(double x_m, double y_m, double angle_rad) {
  Pose pose;
  pose.rotation = Eigen::AngleAxisd(angle_rad, Eigen::Vector3d(1, 2, 0.5).normalized());
  pose.translation_m = {x_m, y_m, 0};
  return pose;
}

SettleBody body(const Mesh& mesh, const Pose& pose) {
  return {&mesh, kDensity * mass_properties(mesh).volume_m3, pose};
}

double lowest_m(const Mesh& mesh, const Pose& pose) {
  double low = 1e9;
  for (const Eigen::Vector3d& v : mesh.vertices_m) low = std::min(low, (pose * v).z());
  return low;
}

TEST(Settle, ABoxComesToLieFlatOnOneOfItsFaces) {
  const Mesh mesh = box_solid({0.006, 0.003, 0.0024});
  const SettleResult result = settle({body(mesh, tilted(0, 0, 0.3))});
  ASSERT_EQ(result.status, SettleStatus::ok);
  const double height_m = result.world_from_body[0].translation_m.z();
  const double off_m = std::min(
      {std::abs(height_m - 0.0012), std::abs(height_m - 0.0015), std::abs(height_m - 0.003)});
  EXPECT_LT(
      off_m,
      1e-6);  // rest depth of the preset is below 1e-4 mm; the rest is the noise of the solver
}

TEST(Settle, AnEllipsoidLiesOnItsFlatSide) {
  const Mesh mesh = ellipsoid_solid({0.003, 0.0017, 0.0015});
  const SettleResult result = settle({body(mesh, tilted(0, 0, 0.6))});
  ASSERT_EQ(result.status, SettleStatus::ok);
  // It rests on a facet of the mesh, off the lowest pose by at most the height a facet of 0.25 mm
  // rises on this curvature.
  EXPECT_NEAR(result.world_from_body[0].translation_m.z(), 0.0015, 3e-5);
}

TEST(Settle, NothingIsThroughTheBoardAndAllIsAtRest) {
  const Mesh pinched = ellipsoid_solid({0.0045, 0.0018, 0.0015}, 0.25);
  const Mesh round = ellipsoid_solid({0.003, 0.0017, 0.0015});
  std::vector<SettleBody> bodies;
  for (int i = 0; i < 6; ++i) {
    bodies.push_back(body(i % 2 == 0 ? pinched : round,
                          tilted(0.015 * (i % 3) - 0.015, 0.012 * (i / 3), 0.9 * i)));
  }
  const SettleConfig config;
  const SettleResult result = settle(bodies, config);
  ASSERT_EQ(result.status, SettleStatus::ok);
  EXPECT_EQ(result.warnings, 0);
  EXPECT_LT(result.kinetic_energy_j, config.rest_energy_j);
  EXPECT_LE(result.max_penetration_m, config.max_penetration_m);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    EXPECT_GE(lowest_m(*bodies[i].mesh, result.world_from_body[i]), -config.max_penetration_m);
    EXPECT_LE(lowest_m(*bodies[i].mesh, result.world_from_body[i]), 1e-6)
        << "body " << i << " hangs in the air";
  }
}

TEST(Settle, BodiesDroppedOnEachOtherDoNotPassThrough) {
  const Mesh mesh = box_solid({0.006, 0.005, 0.002});
  const SettleConfig config{.drop_height_m = 0.001};
  const SettleResult result =
      settle({body(mesh, tilted(0, 0, 0.02)), body(mesh, tilted(0.0004, 0, 0.03))}, config);
  ASSERT_EQ(result.status, SettleStatus::ok);
  EXPECT_NEAR(result.world_from_body[0].translation_m.z(), 0.001, config.max_penetration_m);
  EXPECT_NEAR(result.world_from_body[1].translation_m.z(), 0.003, 2 * config.max_penetration_m);
}

TEST(Settle, RepeatsBitByBitOnAnyNumberOfThreads) {
  const Mesh mesh = ellipsoid_solid({0.0045, 0.0018, 0.0015}, 0.25);
  const std::vector<SettleBody> bodies = {body(mesh, tilted(-0.01, 0, 0.5)),
                                          body(mesh, tilted(0.01, 0, 1.5))};
  const SettleResult first = settle(bodies);
  for (const std::size_t threads : {1, 2, 7}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const SettleResult again = settle(bodies);
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      EXPECT_EQ(again.world_from_body[i].translation_m, first.world_from_body[i].translation_m);
      EXPECT_EQ(again.world_from_body[i].rotation.coeffs(),
                first.world_from_body[i].rotation.coeffs());
    }
  }
}

TEST(Settle, ABodyThatRollsOffSaysSo) {
  const Mesh mesh = ellipsoid_solid({0.003, 0.0017, 0.0015});
  const SettleResult result = settle({body(mesh, tilted(0.06, 0, 0.1))});
  EXPECT_EQ(result.status, SettleStatus::left_board);
}

TEST(Settle, TooShortATimeIsNotRest) {
  const Mesh mesh = box_solid({0.006, 0.003, 0.0024});
  const SettleResult result = settle({body(mesh, tilted(0, 0, 0.3))}, {.max_time_s = 0.06});
  EXPECT_EQ(result.status, SettleStatus::not_at_rest);
}

TEST(Settle, TheKineticEnergyOfAFallIsThatOfTheory) {
  const Mesh mesh = box_solid({0.006, 0.003, 0.0024});
  const double mass_kg = 2e-4;
  const SettleConfig fall{.drag_per_s = 0, .drop_height_m = 0.1, .max_time_s = 0.1};
  const SettleResult result = settle({{&mesh, mass_kg, {}}}, fall);  // it lands after 0.14 s
  EXPECT_EQ(result.status, SettleStatus::not_at_rest);
  const double speed_m_s = 9.81 * result.time_s;  // semi-implicit Euler steps it exactly
  EXPECT_NEAR(result.kinetic_energy_j, 0.5 * mass_kg * speed_m_s * speed_m_s, 1e-12);
}

TEST(Settle, AWarningOfTheEngineIsCountedNamedAndNeverAResult) {
  const Mesh mesh = box_solid({0.006, 0.003, 0.0024});
  // The engine takes coordinates beyond 1e10 for a diverged state, warns, and starts anew.
  const SettleResult far = settle({{&mesh, 1e-4, {}}}, {.drop_height_m = 1e11});
  EXPECT_EQ(far.status, SettleStatus::engine_warning);
  EXPECT_GE(far.warnings, 1);
  EXPECT_THAT(far.first_warning, testing::HasSubstr("huge value in QPOS at DOF 2"));
  // Twenty equal parts touch the board at more points than there is room for.
  ConvexParts parts = convex_parts(mesh);
  parts.hulls.resize(20, parts.hulls[0]);
  const SettleResult full = settle({{&mesh, 1e-4, {}, &parts}});
  EXPECT_EQ(full.status, SettleStatus::engine_warning);
  EXPECT_GT(full.warnings, 1);  // one a step, though the engine says it once
  EXPECT_THAT(full.first_warning, testing::HasSubstr("contact buffer is full"));
  // Nothing of it is left for the next one.
  const SettleResult next = settle({{&mesh, 1e-4, {}}});
  EXPECT_EQ(next.status, SettleStatus::ok);
  EXPECT_EQ(next.warnings, 0);
  EXPECT_EQ(next.first_warning, "");
}

TEST(Settle, NoBodiesAreAtRest) { EXPECT_EQ(settle({}).status, SettleStatus::ok); }

TEST(Settle, BadBodiesAreRefusedByIndex) {
  const Mesh mesh = box_solid({0.006, 0.003, 0.0024});
  EXPECT_THROW(settle({{nullptr, 1e-4, {}}}), std::invalid_argument);
  EXPECT_THROW(settle({{&mesh, 0, {}}}), std::invalid_argument);
  EXPECT_THROW(settle({{&mesh, std::numeric_limits<double>::quiet_NaN(), {}}}),
               std::invalid_argument);
  Mesh shifted = mesh;
  for (Eigen::Vector3d& v : shifted.vertices_m) v.x() += 0.01;
  EXPECT_THROW(settle({{&shifted, 1e-4, {}}}), std::invalid_argument);
  EXPECT_THROW(settle({{&mesh, 1e-4, {}}}, {.step_s = 0}), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
