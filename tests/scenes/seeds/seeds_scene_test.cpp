#include "scenes/seeds/seeds_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <stdexcept>

#include "sim/config/fields.h"
#include "sim/geometry/cube_sphere.h"

namespace cousin {
namespace {

std::vector<Mesh> specimens_in_world(const Scene& scene) {
  std::vector<Mesh> meshes;
  for (const Instance& instance : scene.instances) {
    if (instance.is_specimen) meshes.push_back(mesh_in_world(scene, instance));
  }
  return meshes;
}

double nearest_m(const Mesh& a, const Mesh& b) {  // between every fifth vertex: to 0.3 mm on seeds
  double nearest = 1;
  for (std::size_t i = 0; i < a.vertices_m.size(); i += 5) {
    for (std::size_t j = 0; j < b.vertices_m.size(); j += 5) {
      nearest = std::min(nearest, (a.vertices_m[i] - b.vertices_m[j]).norm());
    }
  }
  return nearest;
}

TEST(SeedsScene, SeedsLieOnTheBoardApartFromEachOtherAndFromTheMarkers) {
  SeedsSceneConfig config;
  config.cultivar = "mixed";
  config.seeds = 6;
  const Scene scene = build_seeds_scene(config, Rng(4));
  const std::vector<Mesh> meshes = specimens_in_world(scene);
  ASSERT_EQ(meshes.size(), 6U);
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    double lowest_m = 1;
    double reach_m = 0;
    for (const Eigen::Vector3d& v : meshes[i].vertices_m) {
      lowest_m = std::min(lowest_m, v.z());
      reach_m = std::max(reach_m, v.head<2>().norm());
    }
    EXPECT_GE(lowest_m, -2e-5) << "seed " << i;  // the limit
    EXPECT_LE(lowest_m, 1e-6) << "seed " << i << " hangs in the air";
    EXPECT_LE(reach_m, 0.038 + 1e-4) << "seed " << i;
    for (std::size_t j = 0; j < i; ++j) EXPECT_GT(nearest_m(meshes[i], meshes[j]), 0.001);
  }
}

TEST(SeedsScene, HasAValidSettingTraitsAndViews) {
  SeedsSceneConfig config;
  config.cultivar = "suijing18";
  config.seeds = 3;
  config.views = 7;
  const Scene scene = build_seeds_scene(config, Rng(1));
  EXPECT_NO_THROW(validate(scene));
  EXPECT_EQ(scene.board, "markers");
  EXPECT_EQ(scene.views.size(), 7U);
  std::set<std::string> categories;
  for (const Instance& instance : scene.instances) {
    categories.insert(instance.category);
    EXPECT_EQ(instance.is_specimen, !instance.traits.empty());
  }
  EXPECT_EQ(categories, (std::set<std::string>{"board", "screen", "suijing18"}));
}

TEST(SeedsScene, RepeatsForTheSameSeed) {
  SeedsSceneConfig config;
  config.cultivar = "xiangyaxiangzhan";
  config.seeds = 3;
  const Scene a = build_seeds_scene(config, Rng(9));
  const Scene b = build_seeds_scene(config, Rng(9));
  for (std::size_t i = 0; i < a.instances.size(); ++i) {
    EXPECT_EQ(a.instances[i].world_from_object.translation_m,
              b.instances[i].world_from_object.translation_m);
    EXPECT_EQ(a.instances[i].world_from_object.rotation.coeffs(),
              b.instances[i].world_from_object.rotation.coeffs());
  }
}

TEST(SeedsScene, MattSeedsDifferInNothingButTheirCoat) {
  SeedsSceneConfig config;
  const Scene glossy = build_seeds_scene(config, Rng(3));
  config.gloss = false;
  const Scene matt = build_seeds_scene(config, Rng(3));
  ASSERT_EQ(matt.instances.size(), glossy.instances.size());
  int seeds = 0;
  for (std::size_t i = 0; i < matt.instances.size(); ++i) {
    const Instance &a = matt.instances[i], &b = glossy.instances[i];
    EXPECT_EQ(a.world_from_object.translation_m, b.world_from_object.translation_m);
    const Material& own = matt.materials[static_cast<std::size_t>(a.material)];
    const Material& coated = glossy.materials[static_cast<std::size_t>(b.material)];
    EXPECT_EQ(own.albedo, coated.albedo);
    seeds += a.is_specimen ? 1 : 0;
    EXPECT_EQ(own.ior == coated.ior, !a.is_specimen) << a.name;
  }
  EXPECT_EQ(seeds, 10);
}

TEST(SeedsScene, TheSphereRestsOnTheBoard) {
  SeedsSceneConfig config;
  config.sphere = true;
  const Scene scene = build_seeds_scene(config, Rng(1));
  const std::vector<Mesh> meshes = specimens_in_world(scene);
  ASSERT_EQ(meshes.size(), 1U);
  EXPECT_NEAR(scene.instances.back().world_from_object.translation_m.z(), 0.011, 2e-5);
}

TEST(SeedsScene, AUsersMeshIsASpecimen) {
  SeedsSceneConfig config;
  config.seeds = 2;
  config.specimen = "mesh:mine.ply";
  const Mesh mesh = make_seed("aikang58", SizeSpread::literature, Rng(1)).model.mesh;
  const Scene scene = build_seeds_scene(config, Rng(1), UserMesh{.mesh = mesh});
  EXPECT_EQ(scene.instances.back().category, "specimen");
  EXPECT_EQ(specimens_in_world(scene).size(), 2U);
}

TEST(SeedsScene, AnOpenMeshOrNoMeshIsRefused) {
  SeedsSceneConfig config;
  config.seeds = 1;
  config.specimen = "mesh:mine.ply";
  EXPECT_THROW(build_seeds_scene(config, Rng(1)), std::invalid_argument);
  Mesh open = make_seed("aikang58", SizeSpread::literature, Rng(1)).model.mesh;
  open.triangles.erase(open.triangles.begin() + 5);
  EXPECT_THROW(build_seeds_scene(config, Rng(1), UserMesh{.mesh = open}), std::runtime_error);
}

double trait(const Instance& instance, const std::string& name) {
  for (const TrueTrait& t : instance.traits) {
    if (t.name == name) return t.value;
  }
  return -1;
}

TEST(SeedsScene, AHeapIsAsVisibleAsAskedForAndItsSeedsTouch) {
  SeedsSceneConfig config;
  config.cultivar = "jimai22";
  config.seeds = 8;
  config.placing = "heap";
  for (const double wish : {0.95, 0.8}) {
    config.visible_fraction = wish;
    const Scene scene = build_seeds_scene(config, Rng(2));
    double visible = 0, touching = 0, lowest_m = 1;
    for (const Instance& instance : scene.instances) {
      if (!instance.is_specimen) continue;
      visible += trait(instance, "visible_fraction") / config.seeds;
      touching += trait(instance, "touching");
      for (const Eigen::Vector3d& v : mesh_in_world(scene, instance).vertices_m)
        lowest_m = std::min(lowest_m, v.z());
    }
    EXPECT_NEAR(visible, wish, 0.03);  // the limit
    EXPECT_GT(touching, 0) << wish;
    EXPECT_GE(lowest_m, -1e-4);  // heap.penetration_m
  }
}

TEST(SeedsScene, AHeapThatCannotBeIsRefusedWithWhatItReaches) {
  SeedsSceneConfig config;
  config.cultivar = "jimai22";
  config.seeds = 2;  // two seeds hide each other by half at most
  config.placing = "heap";
  config.visible_fraction = 0.2;
  try {
    build_seeds_scene(config, Rng(2));
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("visible_fraction = 0.2"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("they reach"), std::string::npos);
  }
  config.placing = "pile";
  EXPECT_THROW(validate(config), std::invalid_argument);
  config.placing = "heap";
  config.seeds = 1;
  EXPECT_THROW(validate(config), std::invalid_argument);
}

TEST(SeedsScene, NoSeedsIsAnEmptyBoard) {
  SeedsSceneConfig config;
  config.seeds = 0;
  EXPECT_TRUE(specimens_in_world(build_seeds_scene(config, Rng(1))).empty());
}

TEST(SeedsScene, TooManySeedsSaySo) {
  SeedsSceneConfig config;
  config.seeds = 12;
  config.specimen = "mesh:ball";
  Mesh ball = cube_sphere(4);  // 12 balls of 30 mm have no room on 76 mm
  for (Eigen::Vector3d& v : ball.vertices_m) v *= 0.015;
  EXPECT_THROW(build_seeds_scene(config, Rng(1), UserMesh{.mesh = ball}), std::runtime_error);
}

TEST(SeedsScene, AWarningOfTheEngineEndsTheSceneAndIsNamed) {
  SeedsSceneConfig config;
  config.seeds = 1;
  config.specimen = "mesh:planet";
  Mesh planet =
      cube_sphere(4);  // its centre rests beyond 1e10, which the engine takes for diverged
  for (Eigen::Vector3d& v : planet.vertices_m) v *= 1e11;
  try {
    build_seeds_scene(config, Rng(1), UserMesh{.mesh = planet});
    FAIL() << "the warning was not fatal";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what())
                  .find("physics engine gave 1 warnings; the first: Nan, Inf or "
                        "huge value in QPOS at DOF 2"),
              std::string::npos)
        << error.what();
  }
}

TEST(SeedsScene, BadConfigurationsNameKeyAndValue) {
  const auto message = [](const SeedsSceneConfig& config) -> std::string {
    try {
      validate(config);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  SeedsSceneConfig config;
  config.cultivar = "barley";
  EXPECT_NE(message(config).find("barley"), std::string::npos);
  config = {};
  config.light = "candle";
  EXPECT_NE(message(config).find("candle"), std::string::npos);
  config = {};
  config.ring_distances_m = {0.4};
  EXPECT_NE(message(config).find("ring_distances_m"), std::string::npos);
  config = {};
  config.distance_min_m = 0.9;
  EXPECT_NE(message(config).find("distance_min_m"), std::string::npos);
  config = {};
  config.distance_max_m = 2;
  EXPECT_NE(message(config).find("distance_max_m"), std::string::npos);
  config = {};
  EXPECT_THROW(set_field(fields(config), "spread=huge"), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
