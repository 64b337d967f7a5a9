#include "scenes/maize/maize_scene.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

namespace cousin {
namespace {

MaizeSceneConfig field(int rows, int plants) {
  MaizeSceneConfig config;
  config.rows = rows;
  config.plants = plants;
  config.plant.field.cell_m = 0.2;  // the soil is not what is tested, nor what stands about
  config.plant.field.far_m = config.plant.field.hedge_m = 0;
  config.plant.field.clods = 0;
  return config;
}

TEST(MaizeScene, RowsShareMeshesAndEveryPlantIsASpecimen) {
  MaizeSceneConfig config = field(3, 7);
  config.plant.field.variants = 4;
  const Scene scene = build_maize_scene(config, Rng(1));
  std::set<int> models, ids;
  int specimens = 0;
  for (const Instance& instance : scene.instances) {
    ids.insert(instance.id);
    if (!instance.is_specimen) continue;
    ++specimens;
    models.insert(instance.model);
    EXPECT_FALSE(instance.traits.empty());
  }
  EXPECT_EQ(specimens, 21);
  EXPECT_EQ(models.size(), 4U);
  EXPECT_EQ(ids.size(), scene.instances.size());
}

TEST(MaizeScene, TheMiddlePlantStandsAtTheOriginAloneOrInAField) {
  const auto middle = [](const Scene& scene) {
    for (const Instance& instance : scene.instances) {
      if (instance.is_specimen && instance.world_from_object.translation_m.norm() == 0)
        return scene.models[static_cast<std::size_t>(instance.model)].mesh.vertices_m;
    }
    return std::vector<Eigen::Vector3d>();
  };
  const auto alone = middle(build_maize_scene(field(1, 1), Rng(2)));
  EXPECT_FALSE(alone.empty());
  EXPECT_EQ(alone, middle(build_maize_scene(field(3, 5), Rng(2))));
}

TEST(MaizeScene, TheFieldGoesOnInStripsThatAreNoSpecimensAndLeaveSightFree) {
  MaizeSceneConfig config = field(1, 1);
  config.stage = "V4";
  config.views = 5;
  config.plant.field.far_m = 6;
  config.plant.field.hedge_m = 5;
  const Scene scene = build_maize_scene(config, Rng(7));
  int strips = 0, specimens = 0;
  double highest_m = 0;
  for (const Instance& instance : scene.instances) {
    specimens += instance.is_specimen;
    const Mesh& mesh = scene.models[static_cast<std::size_t>(instance.model)].mesh;
    if (instance.category == "line of trees") {
      for (const Eigen::Vector3d& p : mesh.vertices_m) highest_m = std::max(highest_m, p.z());
    }
    if (instance.category != "maize far away") continue;
    ++strips;
    for (const View& view : scene.views) {
      const Eigen::Vector3d eye = centre_in_world_m(view.rig_from_world);
      for (const Eigen::Vector3d& p : mesh.vertices_m) {
        // Stalks keep clear_m; leaves of V4 reach half a metre from them.
        ASSERT_GT((instance.world_from_object * p - eye).head<2>().norm(),
                  config.plant.field.clear_m - 0.5);
      }
    }
  }
  EXPECT_EQ(specimens, 1);
  EXPECT_GT(strips, 20);
  EXPECT_GT(highest_m, 3);
  config.plant.field.far_m = config.plant.field.hedge_m = 0;
  EXPECT_EQ(build_maize_scene(config, Rng(7)).models.front().mesh.vertices_m,
            scene.models.front().mesh.vertices_m);
}

TEST(MaizeScene, IsTheSameOnAnyNumberOfThreads) {
  const auto build = [](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return build_maize_scene(field(2, 3), Rng(5));
  };
  const Scene a = build(1), b = build(8);
  ASSERT_EQ(a.models.size(), b.models.size());
  for (std::size_t i = 0; i < a.models.size(); ++i)
    EXPECT_EQ(a.models[i].mesh.vertices_m, b.models[i].mesh.vertices_m) << a.models[i].name;
}

TEST(MaizeScene, ViewsKeepTheirDistanceAndStayAboveTheSoil) {
  MaizeSceneConfig config = field(1, 1);
  config.views = 50;
  for (const View& view : maize_views(config, 1.5, Rng(3))) {
    const Eigen::Vector3d eye = centre_in_world_m(view.rig_from_world);
    EXPECT_GE(eye.z(), 0.1 - 1e-12);
    EXPECT_LE(eye.head<2>().norm(), config.distance_max_m + 1e-12);
    EXPECT_GE(eye.head<2>().norm(), config.distance_min_m * std::cos(config.pitch_max_rad) - 1e-12);
  }
}

TEST(MaizeScene, WholePlantsSwayAboutTheirFeetAndInStillAirNothingChanges) {
  MaizeSceneConfig config = field(2, 2);
  const Scene still = build_maize_scene(config, Rng(6));
  config.motion.wind.mean_speed_m_s = 5;
  config.motion.moves = "plants";
  const Scene windy = build_maize_scene(config, Rng(6));
  ASSERT_EQ(still.instances.size(), windy.instances.size());
  for (std::size_t i = 0; i < still.instances.size(); ++i) {
    const Instance &a = still.instances[i], &b = windy.instances[i];
    EXPECT_TRUE(a.motion.empty());
    EXPECT_EQ(a.world_from_object.translation_m, b.world_from_object.translation_m);
    EXPECT_EQ(still.models[i].mesh.vertices_m, windy.models[i].mesh.vertices_m);
    if (!b.is_specimen) {
      EXPECT_TRUE(b.motion.empty()) << b.name;
      continue;
    }
    const double time_s = windy.views[1].time_s;
    const Pose now = world_from_object(b, time_s), later = world_from_object(b, time_s + 0.1);
    EXPECT_EQ(now.translation_m, a.world_from_object.translation_m);
    EXPECT_GT(angle_rad(now.rotation.conjugate() * later.rotation), 1e-5) << b.name;
  }
}

#if COUSIN_WITH_MUJOCO
TEST(MaizeScene, InWindBladesMoveMoreThanTheStalkAndPlantsOfAMeshMoveEachItsOwnWay) {
  MaizeSceneConfig config = field(2, 2);
  config.plant.field.variants = 2;
  config.motion.wind.mean_speed_m_s = 5;
  const Scene scene = build_maize_scene(config, Rng(6));
  const double time_s = scene.views[1].time_s;
  const auto turn_rad = [&](const Instance& piece) {
    return angle_rad(world_from_object(piece, time_s).rotation.conjugate() *
                     piece.world_from_object.rotation);
  };
  std::map<int, double> largest_rad;  // by plant
  std::map<int, int> pieces_of_model;
  for (const Instance& instance : scene.instances) {
    if (instance.part_of < 0) continue;
    double& largest = largest_rad[instance.part_of];
    largest = std::max(largest, turn_rad(instance));
    ++pieces_of_model[instance.model];
  }
  ASSERT_EQ(largest_rad.size(), 4U);
  for (const auto& [plant, rad] : largest_rad) {
    // A blade turns by some tenths of a radian in 5 m/s, the stalk by hundredths.
    EXPECT_GT(rad, 0.1) << plant;
    EXPECT_LT(rad, 2) << plant;
  }
  for (const auto& [model, count] : pieces_of_model) EXPECT_EQ(count, 2) << model;
  std::set<double> turns;
  for (const auto& [plant, rad] : largest_rad) turns.insert(rad);
  EXPECT_EQ(turns.size(), 4U);
}
#endif

TEST(MaizeScene, RefusesStagesLightsAndOrders) {
  MaizeSceneConfig config = field(1, 1);
  config.stage = "V99";
  EXPECT_THROW(validate(config), std::invalid_argument);
  config = field(1, 1);
  config.light = "moon";
  EXPECT_THROW(validate(config), std::invalid_argument);
  config = field(0, 1);
  EXPECT_THROW(validate(config), std::invalid_argument);
  config = field(1, 1);
  config.distance_min_m = 3;
  EXPECT_THROW(validate(config), std::invalid_argument);
  config = field(1, 1);
  config.plant.blade.width_m.pop_back();
  EXPECT_THROW(validate(config), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
