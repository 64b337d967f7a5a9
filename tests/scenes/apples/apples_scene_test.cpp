#include "scenes/apples/apples_scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <cmath>
#include <stdexcept>

#include "sim/render/truth_pass.h"
#include "sim/truth/specimens.h"
#include "tests/scenes/apples/small_orchard.h"

namespace cousin {
namespace {

using Eigen::Vector3d;
using testing::AllOf;
using testing::HasSubstr;

double trait(const Instance& instance, const std::string& name) {
  for (const TrueTrait& t : instance.traits) {
    if (t.name == name) return t.value;
  }
  throw std::runtime_error(instance.name + " has no " + name);
}

std::string refusal(const ApplesSceneConfig& config) {
  try {
    build_apples_scene(config, Rng(1));
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

/// What the rig's camera sees of the target of a view, by the truth pass.
double visible_fraction(const Scene& scene, const ApplesSceneConfig& config, int view) {
  const RayScene rays(scene);
  TrueView seen;
  seen.camera = config.eye.camera;
  seen.camera_from_world =
      config.eye.eye_from_rig * scene.views[static_cast<std::size_t>(view)].rig_from_world;
  seen.camera_from_world_end = seen.camera_from_world;
  const TruthImages truth = render_truth(rays, scene, seen, {.visibility = true});
  char name[32];
  std::snprintf(name, sizeof name, "target %06d", view);
  const int target = static_cast<int>(trait(scene.instances[0], name));
  for (const InstanceVisibility& v : truth.visibility) {
    if (v.instance == target) return v.visible_fraction;
  }
  throw std::runtime_error("no such target");
}

TEST(ApplesScene, EveryAppleIsASpecimenWithTraitsAndKeypoints) {
  const Scene scene = build_apples_scene(small_orchard(), Rng(1));
  int apples = 0;
  for (const Instance& instance : scene.instances) {
    if (!instance.is_specimen) continue;
    ++apples;
    EXPECT_EQ(label_of(instance, "variety"), "fuji");
    const double red = trait(instance, "red_share");
    EXPECT_EQ(instance.category, red < 0.55 ? "low" : red <= 0.8 ? "medium" : "high");
    EXPECT_EQ(label_of(instance, "maturity"), instance.category);
    for (const char* name : {"length", "diameter", "volume", "mass", "red_share"})
      EXPECT_GT(trait(instance, name), 0) << name;
    const Vector3d axis(trait(instance, "axis_x"), trait(instance, "axis_y"),
                        trait(instance, "axis_z"));
    EXPECT_NEAR(axis.norm(), 1, 1e-12);
    EXPECT_EQ(scene.models[static_cast<std::size_t>(instance.model)].keypoints.size(), 3U);
  }
  EXPECT_EQ(apples, static_cast<int>(trait(scene.instances[0], "fruit_count")));
}

TEST(ApplesScene, IsTheSameOnAnyNumberOfThreads) {
  ApplesSceneConfig config = small_orchard();
  config.occlusion = 0.3;
  config.views = 1;
  const auto build = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return build_apples_scene(config, Rng(5));
  };
  const Scene a = build(1), b = build(8);
  ASSERT_EQ(a.instances.size(), b.instances.size());
  for (std::size_t i = 0; i < a.instances.size(); ++i) {
    EXPECT_EQ(a.instances[i].world_from_object.translation_m,
              b.instances[i].world_from_object.translation_m);
    EXPECT_EQ(a.instances[i].world_from_object.rotation.coeffs(),
              b.instances[i].world_from_object.rotation.coeffs());
  }
  for (std::size_t i = 0; i < a.models.size(); ++i)
    EXPECT_EQ(a.models[i].mesh.vertices_m, b.models[i].mesh.vertices_m) << a.models[i].name;
  EXPECT_EQ(a.views[0].rig_from_world.translation_m, b.views[0].rig_from_world.translation_m);
}

TEST(ApplesScene, ViewsKeepTheirDistanceAndPitch) {
  ApplesSceneConfig config = small_orchard();
  config.views = 9;
  config.look = "up";
  const Scene scene = build_apples_scene(config, Rng(2));
  const auto& range = config.orchard.views.up_rad;
  for (int i = 0; i < config.views; ++i) {
    char name[32];
    std::snprintf(name, sizeof name, "target %06d", i);
    const auto target = static_cast<std::size_t>(trait(scene.instances[0], name));
    const Vector3d from =
        centre_in_world_m(scene.views[static_cast<std::size_t>(i)].rig_from_world) -
        scene.instances[target].world_from_object.translation_m;
    EXPECT_GE(from.norm(), config.distance_min_m - 1e-9);
    EXPECT_LE(from.norm(), config.distance_max_m + 1e-9);
    EXPECT_GE(std::asin(from.z() / from.norm()), range[0] - 1e-9);
    EXPECT_LE(std::asin(from.z() / from.norm()), range[1] + 1e-9);
  }
}

TEST(ApplesScene, ViewsThatMeetTheirOcclusionShowThatShareOfTheTarget) {
  ApplesSceneConfig config = small_orchard();
  config.views = 4;
  int met = 0;
  for (const double occlusion : {0.0, 0.4}) {
    config.occlusion = occlusion;
    const Scene scene = build_apples_scene(config, Rng(7));
    for (int i = 0; i < config.views; ++i) {
      char name[32];
      std::snprintf(name, sizeof name, "met %06d", i);
      if (trait(scene.instances[0], name) != 1) continue;
      ++met;
      EXPECT_NEAR(visible_fraction(scene, config, i), 1 - occlusion, 0.03) << occlusion << " " << i;
    }
  }
  EXPECT_GE(met, 6);  // of 8: in a tree of seven branches some fruits have nothing before them
}

TEST(ApplesScene, OcclusionIsCountedInTheRigsOwnCamera) {
  ApplesSceneConfig config = small_orchard();
  config.views = 2;
  config.occlusion = 0;
  config.eye.eye_from_rig.translation_m.x() = -0.0592;  // of a D455
  const Scene scene = build_apples_scene(config, Rng(7));
  for (int i = 0; i < 2; ++i) EXPECT_GT(visible_fraction(scene, config, i), 0.97);
}

TEST(ApplesScene, AnOcclusionThatCannotBeMetIsStatedOrRefused) {
  ApplesSceneConfig config = small_orchard();
  config.views = 1;
  config.occlusion = 0.95;
  config.sag = false;  // the same tree with and without physics
  config.fruits = 1;
  config.orchard.spur.leaves = 0;  // bare: wood alone hides no fruit so far
  config.orchard.shoot.spacing_m = 5;
  const Scene scene = build_apples_scene(config, Rng(1));
  EXPECT_EQ(trait(scene.instances[0], "met 000000"), 0);
  EXPECT_GT(trait(scene.instances[0], "visible 000000"), 0.08);
  config.unmet = "refuse";
  EXPECT_THAT(refusal(config), AllOf(HasSubstr("occlusion = 0.95"), HasSubstr("view 0")));
}

TEST(ApplesScene, EveryLightShinesAndWrongConfigurationsAreRefusedByName) {
  for (const char* light : {"front", "back", "side", "shade"}) {
    ApplesSceneConfig config = small_orchard();
    config.light = light;
    EXPECT_NO_THROW(validate(config));
  }
  const auto said = [](auto change) {
    ApplesSceneConfig config = small_orchard();
    change(config);
    return refusal(config);
  };
  EXPECT_THAT(said([](auto& c) { c.light = "moon"; }), HasSubstr("front, back, side, shade"));
  EXPECT_THAT(said([](auto& c) { c.distance_min_m = 0.02; }), HasSubstr("inside a fruit"));
  EXPECT_THAT(said([](auto& c) { c.distance_min_m = 2; }), HasSubstr("distance_max_m"));
  EXPECT_THAT(said([](auto& c) { c.occlusion = 1.5; }), HasSubstr("occlusion"));
  EXPECT_THAT(said([](auto& c) { c.look = "away"; }), HasSubstr("up, level, down, any"));
  EXPECT_THAT(said([](auto& c) { c.orchard.wood.albedo = {1}; }), HasSubstr("wood.albedo"));
}

}  // namespace
}  // namespace cousin
