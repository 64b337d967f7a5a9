#include "sim/physics/bending_plant.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "sim/physics/plant_model.h"
#include "sim/physics/plant_motion.h"

namespace cousin {
namespace {

constexpr double kPi = std::numbers::pi;

/// A level stem of 0.3 m and 3 mm across, held at the origin.
BendingStem level_stem(int segments, double modulus_pa) {
  BendingStem stem;
  stem.points_m = {{0, 0, 0}, {0.3, 0, 0}};
  stem.radii_m = {0.0015, 0.0015};
  stem.young_modulus_pa = modulus_pa;
  stem.density_kg_m3 = 900;
  stem.segments = segments;
  return stem;
}

double second_moment_m4(double radius_m) { return kPi / 4 * std::pow(radius_m, 4); }

double tip_m(const BendingPlant& plant, const BentPlant& bent) {
  return centre_line_m(plant, bent, 0).back().z();
}

TEST(BendingPlant, ACantileverSagsAsTheory) {
  BendingPlant plant;
  plant.stems = {level_stem(20, 20e9)};
  const double mass_kg = 0.001;
  plant.loads = {{.stem = 0, .share = 1, .mass_kg = mass_kg, .centroid_m = {0.3, 0, 0}}};
  const SagResult result = sag(plant, {.rest_m = 2e-5});
  ASSERT_EQ(result.status, PlantStatus::ok) << result.moved_m;
  // Tip load P L^3 / 3 E I and own weight w L^4 / 8 E I.
  const double ei = 20e9 * second_moment_m4(0.0015);
  const double own_n_m = 900 * kPi * 0.0015 * 0.0015 * 9.81;
  const double theory_m =
      mass_kg * 9.81 * std::pow(0.3, 3) / (3 * ei) + own_n_m * std::pow(0.3, 4) / (8 * ei);
  // The chain is short by 1 / (4 N^2) = 0.06 %; rest is reached to 0.02 mm in 0.2 s.
  EXPECT_NEAR(-tip_m(plant, result.bent), theory_m, 0.003 * theory_m);
  EXPECT_LT(theory_m, 0.01);  // small against its length, or theory does not hold
}

TEST(BendingPlant, AFloppyStemHangsDown) {
  BendingPlant plant;
  plant.stems = {level_stem(30, 1e6)};
  const SagResult result = sag(plant);
  ASSERT_EQ(result.status, PlantStatus::ok);
  const auto line = centre_line_m(plant, result.bent, 0);
  EXPECT_LT(line.back().z(), -0.25);
  double length = 0;
  for (std::size_t i = 1; i < line.size(); ++i) length += (line[i] - line[i - 1]).norm();
  EXPECT_NEAR(length, 0.3, 0.003);  // chords of at most 20 degrees a hinge
}

/// Angular frequency and decay of a stem let go a little bent, from its tip's zeros and peaks.
struct Ringing {
  double hz = 0;
  double ratio = 0;  ///< of damping
};
Ringing ring(const BendingPlant& plant, double step_s) {
  BentPlant start = sag(plant, {.gravity_m_s2 = 0}).bent;
  for (std::size_t i = 0; i < start.joints_rad[0].size(); i += 3) {
    // The first mode's curvature is about that of a force at the tip.
    const double along = static_cast<double>(i) / static_cast<double>(start.joints_rad[0].size());
    start.joints_rad[0][i] = 0.001 * (1 - along);
    start.joints_rad[0][i + 1] = 0.0005 * (1 - along);
  }
  const SwayConfig config{.step_s = step_s,
                          .sample_s = step_s,
                          .duration_s = 3,
                          .air_density_kg_m3 = 0,
                          .gravity_m_s2 = 0};
  const SwayResult motion = sway(plant, start, {}, config, Rng(1));
  EXPECT_EQ(motion.status, PlantStatus::ok);
  std::vector<double> zeros_s;
  std::vector<double> peaks_m;
  double peak = 0;
  for (std::size_t i = 1; i < motion.frames.size(); ++i) {
    const double a = centre_line_m(plant, motion.frames[i - 1], 0).back().z();
    const double b = centre_line_m(plant, motion.frames[i], 0).back().z();
    peak = std::max(peak, std::abs(b));
    if ((a < 0) == (b < 0)) continue;
    zeros_s.push_back(motion.frames[i - 1].time_s + step_s * a / (a - b));
    peaks_m.push_back(peak);
    peak = 0;
  }
  EXPECT_GT(zeros_s.size(), 10U);
  // The first peaks hold higher modes.
  const auto halves = static_cast<double>(zeros_s.size() - 5);
  Ringing ringing;
  ringing.hz = 0.5 * halves / (zeros_s.back() - zeros_s[4]);
  ringing.ratio = std::log(peaks_m[5] / peaks_m.back()) / ((halves - 1) * kPi);
  return ringing;
}

TEST(BendingPlant, TheFirstFrequencyAndItsDampingAreTheorys) {
  BendingPlant plant;
  plant.stems = {level_stem(20, 1e9)};
  plant.stems[0].damping_time_s = 0.002;
  const Ringing ringing = ring(plant, 0.001);
  const double area = kPi * 0.0015 * 0.0015;
  const double theory_hz = 1.87510407 * 1.87510407 / (2 * kPi * 0.3 * 0.3) *
                           std::sqrt(1e9 * second_moment_m4(0.0015) / (900 * area));
  EXPECT_NEAR(ringing.hz, theory_hz, 0.005 * theory_hz);
  const double theory_ratio = kPi * theory_hz * 0.002;
  EXPECT_NEAR(ringing.ratio, theory_ratio, 0.02 * theory_ratio);
}

TEST(BendingPlant, EnergyFallsFromStepToStepAndIsKeptWithoutDamping) {
  BendingPlant plant;
  plant.stems = {level_stem(10, 1e9)};
  for (const double tau_s : {0.0, 0.002}) {
    plant.stems[0].damping_time_s = tau_s;
    const EngineWatch watch;
    const HingedPlant engine =
        make_plant_model(plant, {.step_s = 2e-5, .gravity_m_s2 = 0, .twists = false});
    const EngineData data = make_data(*engine.model);
    for (const PlantHinge& hinge : engine.hinges) data->qpos[hinge.first_angle] = 0.002;
    mj_forward(engine.model.get(), data.get());
    const double first_j = energy_of(engine, *data).elastic_j;
    double before_j = first_j;
    for (int look = 0; look < 100; ++look) {
      for (int i = 0; i < 100; ++i) mj_step(engine.model.get(), data.get());
      const PlantEnergy energy = energy_of(engine, *data);
      const double now_j = energy.elastic_j + energy.kinetic_j;
      // The symplectic step lets it swing by about omega h of the highest mode that moves.
      if (tau_s > 0) EXPECT_LT(now_j, before_j);
      if (!(tau_s > 0)) EXPECT_NEAR(now_j, first_j, 0.02 * first_j);
      before_j = now_j;
    }
    if (tau_s > 0) EXPECT_LT(before_j, 0.9 * first_j);
    EXPECT_EQ(watch.warnings(*data), 0);
  }
}

TEST(BendingPlant, AFruitTooHeavyForItsStalkBreaksItAndSaysWhere) {
  BendingPlant plant;
  plant.stems = {level_stem(20, 5e8)};
  plant.stems[0].strength_pa = 5e6;
  plant.loads = {{.stem = 0, .share = 1, .mass_kg = 0.001, .centroid_m = {0.3, 0, 0}}};
  EXPECT_EQ(sag(plant).status, PlantStatus::ok);
  plant.loads[0].mass_kg = 0.2;
  const SagResult heavy = sag(plant);
  EXPECT_EQ(heavy.status, PlantStatus::broke);
  EXPECT_EQ(heavy.strain.stem, 0);
  EXPECT_LT(heavy.strain.share, 0.3);
  EXPECT_GT(heavy.strain.stress_pa, 5e6);
}

TEST(BendingPlant, TheStressAtTheRootIsThatOfABeam) {
  BendingPlant plant;
  plant.stems = {level_stem(40, 20e9)};
  plant.stems[0].density_kg_m3 = 1;
  plant.loads = {{.stem = 0, .share = 1, .mass_kg = 0.001, .centroid_m = {0.3, 0, 0}}};
  const SagResult result = sag(plant, {.rest_m = 2e-5});
  // M r / I at the first hinge, half a segment from the root.
  const double theory_pa = 0.001 * 9.81 * (0.3 - 0.3 / 80) * 0.0015 / second_moment_m4(0.0015);
  EXPECT_NEAR(result.strain.stress_pa, theory_pa, 0.005 * theory_pa);
}

void expect_refusal(const BendingPlant& plant, const char* text) {
  try {
    sag(plant);
    FAIL() << text;
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr(text));
  }
}

TEST(BendingPlant, WhatCannotBeBentIsRefusedByName) {
  BendingPlant plant;
  plant.stems = {level_stem(20, 1e9), level_stem(20, 1e9)};
  BendingPlant thin = plant;
  thin.stems[1].radii_m = {1e-5, 1e-5};
  expect_refusal(thin, "stem 1: radius in m is 1e-05");
  BendingPlant late = plant;
  late.stems[0].parent = 1;
  expect_refusal(late, "stem 0: parent is 1");
  BendingPlant away = plant;
  away.stems[1].parent = 0;
  expect_refusal(away, "distance in m of its base");
  BendingPlant none = plant;
  none.loads = {{.stem = 2, .mass_kg = 0.01}};
  expect_refusal(none, "load 0: stem is 2");
  BendingPlant nan = plant;
  nan.stems[0].young_modulus_pa = std::numeric_limits<double>::quiet_NaN();
  expect_refusal(nan, "young_modulus_pa is nan");
  const BentPlant rest = sag(plant, {.gravity_m_s2 = 0}).bent;
  try {
    sway(plant, rest, {}, {.wind = {.mean_speed_m_s = 40}}, Rng(1));
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("mean_speed_m_s"));
    EXPECT_THAT(error.what(), testing::HasSubstr("40"));
  }
  plant.stems[0].damping_time_s = 1e-4;
  EXPECT_THROW(sway(plant, rest, {}, {}, Rng(1)), std::invalid_argument);
}

TEST(BendingPlant, AStemLaidOverABedRestsOnIt) {
  BendingPlant plant;
  plant.stems = {level_stem(30, 3e7)};
  for (Eigen::Vector3d& p : plant.stems[0].points_m) p.z() += 0.003;
  plant.loads = {{.stem = 0, .share = 1, .mass_kg = 0.02, .centroid_m = {0.3, 0, 0.003}}};
  BendingObstacle bed;
  bed.world_from_box.translation_m = {0, 0, -0.1};
  bed.half_m = {0.15, 0.2, 0.1};
  plant.obstacles = {bed};
  const SagResult result = sag(plant);
  EXPECT_EQ(result.status, PlantStatus::ok) << to_string(result.status) << result.first_warning;
  EXPECT_LT(result.max_penetration_m, 5e-4);
  EXPECT_LT(tip_m(plant, result.bent), -0.12);
}

TEST(BendingPlant, SidesOfABedThatNothingReachesChangeNothing) {
  const auto rest_on = [](double half_y_m) {
    BendingPlant plant;
    plant.stems = {level_stem(30, 3e7)};
    for (Eigen::Vector3d& p : plant.stems[0].points_m) p.z() += 0.003;
    plant.loads = {{.stem = 0, .share = 1, .mass_kg = 0.02, .centroid_m = {0.3, 0, 0.003}}};
    BendingObstacle bed;
    bed.world_from_box.translation_m = {0, 0, -0.1};
    bed.half_m = {0.15, half_y_m, 0.1};
    plant.obstacles = {bed};
    return tip_m(plant, sag(plant).bent);
  };
  // The stem is 0.3 m long. Contacts depend on the sizes of what touches, to rounding.
  EXPECT_NEAR(rest_on(0.5), rest_on(3), 1e-5);
  // Within its reach sides are there: a narrow bed's stem slides off no sooner than a wide one's.
  EXPECT_NEAR(rest_on(0.2), rest_on(3), 1e-3);
}

TEST(BendingPlant, AChildStemMovesWithWhatCarriesIt) {
  BendingPlant plant;
  plant.stems = {level_stem(10, 5e7), level_stem(10, 1e11)};
  plant.stems[1].parent = 0;
  plant.stems[1].points_m = {{0.3, 0, 0}, {0.3, 0, 0.05}};
  const SagResult result = sag(plant);
  ASSERT_EQ(result.status, PlantStatus::ok);
  const auto parent = centre_line_m(plant, result.bent, 0);
  const auto child = centre_line_m(plant, result.bent, 1);
  EXPECT_LT((parent.back() - child.front()).norm(), 1e-12);
  // Still square to the parent's end, which is a section of its own there.
  const Eigen::Vector3d end =
      bent_from_unbent(plant, result.bent, 0, 1).rotation * Eigen::Vector3d::UnitX();
  EXPECT_NEAR(end.dot((child.back() - child.front()).normalized()), 0, 1e-3);
}

TEST(Sway, RestUnderWeightStaysRestInStillAir) {
  BendingPlant plant;
  plant.stems = {level_stem(15, 2e8)};
  const SagResult rest = sag(plant, {.rest_m = 2e-5});
  const SwayResult motion = sway(plant, rest.bent, {}, {.duration_s = 0.3}, Rng(1));
  ASSERT_EQ(motion.status, PlantStatus::ok);
  EXPECT_EQ(motion.frames.size(), 31U);
  // What sag leaves, 0.02 mm in 0.2 s, for as long again.
  EXPECT_NEAR(tip_m(plant, motion.frames.back()), tip_m(plant, rest.bent), 5e-5);
}

TEST(Sway, WindBendsDownwindByDragAndHandsPush) {
  BendingPlant plant;
  plant.stems = {level_stem(15, 1e9)};
  plant.stems[0].points_m = {{0, 0, 0}, {0, 0, 0.3}};
  plant.stems[0].damping_time_s = 0.05;
  const BentPlant rest = sag(plant).bent;
  SwayConfig config{.duration_s = 3, .gravity_m_s2 = 0};
  config.wind.mean_speed_m_s = 3;
  config.wind.intensity = 0;
  const SwayResult motion = sway(plant, rest, {}, config, Rng(1));
  ASSERT_EQ(motion.status, PlantStatus::ok);
  // Even drag q = 1/2 rho Cd d U^2 a metre: q L^4 / 8 E I.
  const double q = 0.5 * 1.2 * 1.1 * 0.003 * 9;
  const double theory_m = q * std::pow(0.3, 4) / (8 * 1e9 * second_moment_m4(0.0015));
  const double tip = centre_line_m(plant, motion.frames.back(), 0).back().x();
  // The first half segment, by the root, feels no wind; the chain's own error is less.
  EXPECT_NEAR(tip, theory_m, 0.01 * theory_m);

  config.wind.mean_speed_m_s = 0;
  config.duration_s = 0.5;
  const SwayResult pushed =
      sway(plant, rest, {{.stem = 0, .share = 1, .force_n = {0, 0.01, 0}}}, config, Rng(1));
  double farthest = 0;
  for (const BentPlant& frame : pushed.frames)
    farthest = std::max(farthest, centre_line_m(plant, frame, 0).back().y());
  // 0.5 s is slow beside the stem's 14 Hz, and it bends by a twelfth of its length: P L^3 / 3 E I.
  EXPECT_NEAR(farthest, 0.01 * 0.027 / (3 * 1e9 * second_moment_m4(0.0015)), 0.05 * farthest);
}

TEST(Sway, RepeatsBitByBitAndDiffersWithTheSeed) {
  BendingPlant plant;
  plant.stems = {level_stem(10, 2e8)};
  const BentPlant rest = sag(plant).bent;
  SwayConfig config{.duration_s = 0.2};
  config.wind.mean_speed_m_s = 4;
  const auto tip = [&](std::uint64_t seed) {
    return centre_line_m(plant, sway(plant, rest, {}, config, Rng(seed)).frames.back(), 0).back();
  };
  EXPECT_EQ(tip(1), tip(1));
  EXPECT_NE(tip(1), tip(2));
}

TEST(Sway, AStormBreaksAWeakStem) {
  BendingPlant plant;
  plant.stems = {level_stem(15, 1e9)};
  plant.stems[0].points_m = {{0, 0, 0}, {0, 0, 0.3}};
  plant.stems[0].strength_pa = 2e6;
  const BentPlant rest = sag(plant).bent;
  SwayConfig config{.duration_s = 2};
  config.wind.mean_speed_m_s = 25;
  const SwayResult motion = sway(plant, rest, {}, config, Rng(1));
  EXPECT_EQ(motion.status, PlantStatus::broke);
  EXPECT_LT(motion.frames.back().time_s, 2);
}

TEST(Sway, MotionOfALeafIsTheMotionOfItsSection) {
  BendingPlant plant;
  plant.stems = {level_stem(10, 2e8)};
  const SagResult rest = sag(plant);
  const std::vector<BentPlant> frames = {rest.bent};
  Pose leaf;
  leaf.translation_m = {0.3, 0.01, 0};
  const std::vector<TimedPose> motion = motion_of(plant, frames, 0, 1, leaf);
  ASSERT_EQ(motion.size(), 1U);
  const Eigen::Vector3d moved = bent_from_unbent(plant, rest.bent, 0, 1) * leaf.translation_m;
  EXPECT_LT((motion[0].world_from_object.translation_m - moved).norm(), 1e-15);
}

}  // namespace
}  // namespace cousin
