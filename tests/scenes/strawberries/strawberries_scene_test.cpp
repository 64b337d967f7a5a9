#include "scenes/strawberries/strawberries_scene.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "scenes/strawberries/bed_outline.h"
#include "sim/geometry/measure.h"
#include "sim/truth/specimens.h"
#include "tests/scenes/strawberries/small_stretch.h"

namespace cousin {
namespace {

double trait_of(const Instance& instance, const std::string& name) {
  for (const TrueTrait& trait : instance.traits) {
    if (trait.name == name) return trait.value;
  }
  throw std::logic_error(instance.name + " has no trait " + name);
}

const ObjectModel& model_of(const Scene& scene, const Instance& instance) {
  return scene.models[static_cast<std::size_t>(instance.model)];
}

TEST(StrawberriesScene, FruitsAreSpecimensWithTraitsAxisAndKeypoints) {
  const Scene scene = weightless_scene(small_stretch(4), 1, 2);
  int fruits = 0;
  std::set<std::string> names;
  for (const Instance& instance : scene.instances) {
    EXPECT_TRUE(names.insert(instance.name + std::to_string(instance.id)).second);
    if (!instance.is_specimen) continue;
    ++fruits;
    const ObjectModel& model = model_of(scene, instance);
    std::set<std::string> keypoints;
    for (const Keypoint& keypoint : model.keypoints) keypoints.insert(keypoint.name);
    EXPECT_EQ(keypoints, (std::set<std::string>{"tip", "calyx_centre", "cut_point"}));
    const Eigen::Vector3d axis(trait_of(instance, "axis_x"), trait_of(instance, "axis_y"),
                               trait_of(instance, "axis_z"));
    EXPECT_NEAR(axis.norm(), 1, 1e-12);
    EXPECT_EQ(trait_of(instance, "maturity"), maturity_of(trait_of(instance, "red_share")));
    // Volume is the flesh's: achenes, closed bodies in it, add less than a twentieth.
    EXPECT_NEAR(mass_properties(model.mesh).volume_m3 / trait_of(instance, "volume"), 1, 0.05);
    EXPECT_GT(instance.mass_kg, 0);
  }
  EXPECT_EQ(fruits, 4);
}

TEST(StrawberriesScene, AnotherSceneOfAStretchHasOtherColoursAndViewsAndTheSameShapes) {
  const StrawberriesSceneConfig config = small_stretch(5);
  const Scene a = weightless_scene(config, 3, 10), b = weightless_scene(config, 3, 11);
  ASSERT_EQ(a.instances.size(), b.instances.size());
  int recoloured = 0;
  for (std::size_t i = 0; i < a.instances.size(); ++i) {
    const ObjectModel &ma = model_of(a, a.instances[i]), &mb = model_of(b, b.instances[i]);
    if (a.instances[i].category == "calyx") continue;  // turns back as the fruit ripens
    EXPECT_EQ(ma.mesh.vertices_m, mb.mesh.vertices_m) << a.instances[i].name;
    if (a.instances[i].is_specimen && ma.vertex_albedo != mb.vertex_albedo) ++recoloured;
  }
  EXPECT_GT(recoloured, 0);
  EXPECT_NE(a.views.front().rig_from_world.translation_m,
            b.views.front().rig_from_world.translation_m);
}

TEST(StrawberriesScene, WithoutRipeningColoursAreThoseOfTheStretch) {
  StrawberriesSceneConfig config = small_stretch(3);
  config.ripens = false;
  const Scene a = weightless_scene(config, 4, 10), b = weightless_scene(config, 4, 11);
  for (std::size_t i = 0; i < a.instances.size(); ++i) {
    if (!a.instances[i].is_specimen) continue;
    EXPECT_EQ(model_of(a, a.instances[i]).vertex_albedo, model_of(b, b.instances[i]).vertex_albedo);
  }
}

TEST(StrawberriesScene, PlantsKeepOffFruits) {
  StrawberriesSceneConfig config = small_stretch(8);
  // Weightless trusses stand up among the leaves.
  const Scene scene = weightless_scene(config, 5, 1);
  // They keep clear_m off by vertices; edges between come nearer by their sagitta.
  EXPECT_LT(plants_in_fruits_m(scene), 0);
  // Moved into the foliage, a fruit is found there.
  Scene moved = scene;
  Eigen::Vector3d leaf = Eigen::Vector3d::Zero();
  for (const Instance& instance : moved.instances) {
    if (instance.name == "plant 01") leaf = mesh_in_world(moved, instance).vertices_m.back();
  }
  for (Instance& instance : moved.instances) {
    if (instance.is_specimen) instance.world_from_object.translation_m = leaf;
  }
  EXPECT_GT(plants_in_fruits_m(moved), 0.005);
}

TEST(StrawberriesScene, TheFilmStaysInTheBedThatTrussesHangOver) {
  const StrawberriesSceneConfig config = small_stretch(1);
  const Scene scene = weightless_scene(config, 6, 1);
  const std::vector<BendingObstacle> bed = bed_obstacles(config.stand.truss);
  ASSERT_EQ(bed.size(), 3U);
  for (const Instance& instance : scene.instances) {
    if (instance.name != "bed") continue;
    for (Eigen::Vector3d p : mesh_in_world(scene, instance).vertices_m) {
      // On top the tube under the film lifts it, beyond what trusses lie on.
      const double off = (p.x() + config.bed.drip.under_m) / (2 * config.bed.drip.radius_m);
      p.y() = 0;  // the film goes on beyond where trusses hang
      EXPECT_GE(depth_m(bed, p), -config.bed.drip.rise_m * std::exp(-off * off) - 1e-9);
      EXPECT_GE(p.z(), -config.stand.truss.bed_height_m - config.bed.film.wrinkle_m);
    }
    return;
  }
  FAIL() << "no bed";
}

TEST(StrawberriesScene, TheBedsOutlineIsTheSurfaceOfItsBoxes) {
  for (const double slope_rad : {0.0, 0.26, 0.6}) {
    TrussShape shape = truss_shape();
    shape.bed_slope_rad = slope_rad;
    const std::vector<BendingObstacle> bed = bed_obstacles(shape);
    const BedOutline outline = bed_outline(shape, 0.01);
    for (std::size_t i = 0; i < outline.points_m.size(); ++i) {
      const Eigen::Vector2d& p = outline.points_m[i];
      if (slope_rad == 0 && p.y() < -shape.bed_height_m + shape.bed_round_m)
        continue;  // the box is round there, too
      EXPECT_NEAR(depth_m(bed, Eigen::Vector3d(p.x(), 0, p.y())), 0, 1e-12) << p.transpose();
    }
  }
}

TEST(StrawberriesScene, ViewsAreNearTheFruitsHeightAndLevelOrTilted) {
  StrawberriesSceneConfig config = small_stretch(1);
  config.views = 200;
  const Eigen::Vector3d middle_m(0.02, 0.01, -0.14);
  int tilted = 0;
  for (const View& view : strawberry_views(config, middle_m, Rng(7))) {
    const Eigen::Vector3d off = centre_in_world_m(view.rig_from_world) - middle_m;
    EXPECT_LE(std::abs(off.z()), config.height_m + 1e-9);
    EXPECT_GE(off.head<2>().norm(), config.distance_min_m - 0.06);  // aside by two sigmas of 3 cm
    EXPECT_LE(off.head<2>().norm(), config.distance_max_m + 0.06);
    const Eigen::Vector3d along =
        view.rig_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ();
    const double pitch = -std::asin(along.z());
    const bool is_tilted = pitch >= config.pitch_min_rad - 1e-9;
    EXPECT_LE(pitch, config.pitch_max_rad + 1e-9);
    if (!is_tilted) EXPECT_LE(std::abs(pitch), 0.06 + 1e-9);  // two sigmas of a level by hand
    tilted += is_tilted ? 1 : 0;
  }
  // Binomial of 200 and a half: sigma 7; allow four.
  EXPECT_NEAR(tilted, 100, 28);
}

TEST(StrawberriesScene, EveryLightIsValid) {
  for (const std::string& light : strawberry_lights()) {
    StrawberriesSceneConfig config = small_stretch(1);
    config.light = light;
    EXPECT_NO_THROW(weightless_scene(config, 8, 1)) << light;
  }
}

TEST(StrawberriesScene, MaturityHasThePapersBounds) {
  EXPECT_EQ(maturity_of(0.29), 0);
  EXPECT_EQ(maturity_of(0.3), 1);
  EXPECT_EQ(maturity_of(0.8), 1);
  EXPECT_EQ(maturity_of(0.81), 2);
}

TEST(StrawberriesScene, FruitsAreOfTheCategoryAskedFor) {
  StrawberriesSceneConfig config = small_stretch(3);
  const Scene by_maturity = weightless_scene(config, 9, 1);
  config.category = "variety";
  const Scene by_variety = weightless_scene(config, 9, 1);
  const std::vector<std::string> varieties = strawberry_varieties();
  int fruits = 0;
  for (std::size_t i = 0; i < by_maturity.instances.size(); ++i) {
    const Instance &a = by_maturity.instances[i], &b = by_variety.instances[i];
    EXPECT_EQ(a.labels.size(), a.is_specimen ? 2U : 0U) << a.name;
    if (!a.is_specimen) continue;
    ++fruits;
    EXPECT_EQ(a.category, kMaturities.at(static_cast<std::size_t>(trait_of(a, "maturity"))));
    EXPECT_EQ(label_of(a, "maturity"), a.category);
    EXPECT_EQ(label_of(a, "variety"), b.category);
    EXPECT_EQ(label_of(b, "maturity"), a.category);
    EXPECT_TRUE(std::find(varieties.begin(), varieties.end(), b.category) != varieties.end());
    EXPECT_EQ(variety_of(a), b.category);  // tables of cultivars name it either way
  }
  EXPECT_GT(fruits, 1);
}

TEST(StrawberriesScene, MaturityIsByTheSharesOfTheConfiguration) {
  StrawberriesSceneConfig config = small_stretch(3);
  config.stand.truss.maturity_medium = config.stand.truss.maturity_high = 0;
  for (const Instance& instance : weightless_scene(config, 9, 1).instances) {
    if (instance.is_specimen)
      EXPECT_EQ(instance.category, trait_of(instance, "red_share") > 0 ? "high" : "medium");
  }
  config.stand.truss.maturity_medium = 0.5;
  config.stand.truss.maturity_high = 0.4;
  EXPECT_THROW(validate(config), std::invalid_argument);
}

TEST(StrawberriesScene, IsTheSameOnAnyNumberOfThreads) {
  const auto build = [](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return weightless_scene(small_stretch(5), 5, 6);
  };
  const Scene a = build(1), b = build(8);
  ASSERT_EQ(a.models.size(), b.models.size());
  for (std::size_t i = 0; i < a.models.size(); ++i) {
    EXPECT_EQ(a.models[i].mesh.vertices_m, b.models[i].mesh.vertices_m) << a.models[i].name;
    ASSERT_EQ(a.models[i].vertex_albedo.size(), b.models[i].vertex_albedo.size());
  }
}

std::string refusal(const std::function<void(StrawberriesSceneConfig&)>& change) {
  StrawberriesSceneConfig config = small_stretch(2);
  change(config);
  try {
    weightless_scene(config, 1, 1);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(StrawberriesScene, BadRequestsAreRefusedByName) {
  using Config = StrawberriesSceneConfig;
  const auto names = [](const std::string& message, const char* key) {
    return message.find(key) != std::string::npos;
  };
  EXPECT_TRUE(names(refusal([](Config& c) { c.stand.fruits_min = 0; }), "fruits_min"));
  EXPECT_TRUE(names(refusal([](Config& c) { c.stand.fruits_max = 500; }), "fruits_max"));
  EXPECT_TRUE(names(refusal([](Config& c) { c.stand.fruits_min = 3; }), "fruits_min"));
  EXPECT_TRUE(names(refusal([](Config& c) { c.stand.variety = "albion"; }), "benihoppe"));
  EXPECT_TRUE(names(refusal([](Config& c) { c.light = "dusk"; }), "overcast"));
  EXPECT_TRUE(names(refusal([](Config& c) { c.category = "colour"; }), "maturity"));
  EXPECT_TRUE(names(refusal([](Config& c) { c.distance_min_m = 0.001; }), "distance_min_m"));
  EXPECT_TRUE(names(refusal([](Config& c) { c.pitch_max_rad = 0.1; }), "pitch_min_rad"));
  // One fruit is the middle itself.
  EXPECT_TRUE(names(refusal([](Config& c) {
                      c.stand.fruits_min = c.stand.fruits_max = 1;
                      c.distance_min_m = c.distance_max_m = 0.008;
                      c.height_m = 0;
                      c.views = 40;
                    }),
                    "inside fruit 0"));
}

}  // namespace
}  // namespace cousin
