#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "scenes/seedlings/seedlings_scene.h"
#include "sim/plant/organ_surface.h"
#include "sim/truth/specimens.h"

namespace cousin {
namespace {

SeedlingsSceneConfig small_tray() {
  SeedlingsSceneConfig config;
  config.day = 9;
  config.setting.tray.columns = 3;
  config.setting.tray.rows = 2;
  config.setting.tray.empty_share = 0;
  config.plant.emergence.failed_share = 0;
  config.setting.substrate.detail_m = 0.01;
  config.setting.substrate.perlite = 2;
  config.plant.surface.detail_m = 0.003;
  config.views = 2;
  return config;
}

TEST(SeedlingsMotion, RefusesOtherMotionsAndHandsOnNothing) {
  SeedlingsSceneConfig config = small_tray();
  config.motion.moves = "legs";
  EXPECT_THROW(validate(config), std::invalid_argument);
  config = small_tray();
  config.motion.moves = "plants";
  config.motion.push.force_n = 0.01;
  EXPECT_THROW(validate(config), std::invalid_argument);
  for (const auto& spoil : std::vector<std::function<void(HandConfig&)>>{
           [](HandConfig& h) { h.plant = 77; }, [](HandConfig& h) { h.leaf = 9; },
           [](HandConfig& h) { h.view = 2; }}) {
    config = small_tray();
    config.motion.push.force_n = 0.01;
    spoil(config.motion.push);
    EXPECT_THROW(build_seedlings_scene(config, Rng(3)), std::invalid_argument);
  }
}

TEST(SeedlingsMotion, WholePlantsAreStillOnesWithAMotion) {
  SeedlingsSceneConfig config = small_tray();
  const Scene still = build_seedlings_scene(config, Rng(3));
  config.motion.wind.mean_speed_m_s = 3;
  config.motion.moves = "plants";
  const Scene windy = build_seedlings_scene(config, Rng(3));
  ASSERT_EQ(still.instances.size(), windy.instances.size());
  for (std::size_t i = 0; i < still.instances.size(); ++i) {
    EXPECT_TRUE(still.instances[i].motion.empty());
    EXPECT_EQ(!windy.instances[i].motion.empty(), windy.instances[i].is_specimen);
  }
}

#if COUSIN_WITH_MUJOCO

Scene windy_tray(double wind_m_s) {
  SeedlingsSceneConfig config = small_tray();
  config.motion.wind.mean_speed_m_s = wind_m_s;
  return build_seedlings_scene(config, Rng(3));
}

double turn_rad(const Instance& piece, double time_s) {
  return angle_rad(world_from_object(piece, time_s).rotation.conjugate() *
                   piece.world_from_object.rotation);
}

TEST(SeedlingsMotion, TheOrgansOfAPlantAreAllItsSurfaceAndKeepItsTraitsAndKeypoints) {
  const Scene still = windy_tray(0), windy = windy_tray(3);
  const auto a = specimens_of(still), b = specimens_of(windy);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i]->id, b[i]->id);
    EXPECT_EQ(a[i]->name, b[i]->name);
    ASSERT_EQ(a[i]->traits.size(), b[i]->traits.size());
    for (std::size_t t = 0; t < a[i]->traits.size(); ++t)
      EXPECT_EQ(a[i]->traits[t].value, b[i]->traits[t].value);
    const ObjectModel& whole = still.models[static_cast<std::size_t>(a[i]->model)];
    const ObjectModel& foot = windy.models[static_cast<std::size_t>(b[i]->model)];
    EXPECT_EQ(whole.part_names, foot.part_names);
    ASSERT_EQ(whole.keypoints.size(), foot.keypoints.size());
    double area_m2 = 0;
    const auto places = places_of(windy, *b[i]);
    EXPECT_GT(places.size(), 5U);  // stem, two cotyledons, leaves
    for (const std::size_t place : places) {
      area_m2 += surface_area_m2(
          windy.models[static_cast<std::size_t>(windy.instances[place].model)].mesh);
    }
    EXPECT_NEAR(area_m2, surface_area_m2(whole.mesh), 1e-12);
  }
}

TEST(SeedlingsMotion, LeavesTurnMoreThanTheStemAndMoreInMoreWind) {
  double calm = 0, strong = 0;
  for (const double wind_m_s : {1.0, 6.0}) {
    const Scene scene = windy_tray(wind_m_s);
    for (const Instance* plant : specimens_of(scene)) {
      double most = 0, at_leaf_tip = 0;
      for (std::size_t k = 0; k < plant->keypoint_carriers.size(); ++k) {
        const Instance& carrier = scene.instances[carrier_of(scene, *plant, k)];
        const std::string& name =
            scene.models[static_cast<std::size_t>(plant->model)].keypoints[k].name;
        const double turn = turn_rad(carrier, scene.views[1].time_s);
        if (name == "collar") EXPECT_LT(turn, 0.05) << plant->name;
        if (name == "leaf 1 tip") at_leaf_tip = turn;
        most = std::max(most, turn);
      }
      EXPECT_GT(at_leaf_tip, 0) << plant->name;
      (wind_m_s < 2 ? calm : strong) += most;
    }
  }
  EXPECT_GT(strong, 2 * calm);
}

TEST(SeedlingsMotion, IsTheSameOnAnyNumberOfThreads) {
  const auto build = [](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return windy_tray(4);
  };
  const Scene a = build(1), b = build(8);
  ASSERT_EQ(a.instances.size(), b.instances.size());
  for (std::size_t i = 0; i < a.instances.size(); ++i) {
    const auto &x = a.instances[i].motion, &y = b.instances[i].motion;
    ASSERT_EQ(x.size(), y.size());
    for (std::size_t k = 0; k < x.size(); ++k) {
      EXPECT_EQ(x[k].time_s, y[k].time_s);
      EXPECT_EQ(x[k].world_from_object.translation_m, y[k].world_from_object.translation_m);
      EXPECT_EQ(x[k].world_from_object.rotation.coeffs(), y[k].world_from_object.rotation.coeffs());
    }
  }
}

TEST(SeedlingsMotion, AHandMovesOneLeafWhileItsViewIsTakenAndNoOtherPlant) {
  SeedlingsSceneConfig config = small_tray();
  config.motion.push.force_n = 0.01;
  config.motion.push.plant = 2;
  config.motion.push.leaf = 1;
  config.motion.push.view = 1;
  const Scene scene = build_seedlings_scene(config, Rng(3));
  double then = 0, before = 0;
  for (const Instance& instance : scene.instances) {
    if (!is_of_specimen(instance)) continue;
    if (!instance.name.starts_with("seedling 02")) {
      EXPECT_TRUE(instance.motion.empty()) << instance.name;
      continue;
    }
    then = std::max(then, turn_rad(instance, scene.views[1].time_s));
    before = std::max(before, turn_rad(instance, scene.views[0].time_s));
  }
  EXPECT_GT(then, 0.1);
  EXPECT_LT(before, 1e-9);
}

#endif

}  // namespace
}  // namespace cousin
