#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "sim/render/ray_scene.h"
#include "sim/render/truth_pass.h"
#include "tests/scenes/strawberries/small_stretch.h"

namespace cousin {
namespace {

double bed_trait(const Scene& scene, const char* what, int view) {
  char name[40];
  std::snprintf(name, sizeof name, "%s %06d", what, view);
  for (const TrueTrait& trait : scene.instances.front().traits) {
    if (trait.name == name) return trait.value;
  }
  throw std::logic_error(std::string("no trait ") + name);
}

StrawberriesSceneConfig occluded(double occlusion, int views) {
  StrawberriesSceneConfig config = small_stretch(5);
  config.occlusion = occlusion;
  config.views = views;
  return config;
}

TEST(StrawberryTargets, WhatTheRigsCameraSeesIsWhatTheNotesSay) {
  for (const double occlusion : {0.3, 0.7}) {
    const StrawberriesSceneConfig config = occluded(occlusion, 2);
    const Scene scene = weightless_scene(config, 1, 2);
    const RayScene rays(scene);
    for (int i = 0; i < config.views; ++i) {
      ASSERT_EQ(bed_trait(scene, "met", i), 1) << occlusion;
      TrueView seen;
      seen.camera = config.eye.camera;
      seen.camera_from_world = scene.views[static_cast<std::size_t>(i)].rig_from_world;
      seen.camera_from_world_end = seen.camera_from_world;
      const auto target = static_cast<int>(bed_trait(scene, "target", i));
      double fraction = -1;
      for (const InstanceVisibility& v :
           render_truth(rays, scene, seen, {.visibility = true}).visibility) {
        if (v.instance == target) fraction = v.visible_fraction;
      }
      // The search counts 96 pixels across the fruit, the camera a few dozen.
      EXPECT_NEAR(fraction, 1 - occlusion, 0.03 + 0.01);
    }
  }
}

TEST(StrawberryTargets, ScenesWithAndWithoutTargetsHaveTheSameFruits) {
  StrawberriesSceneConfig config = small_stretch(3);
  const Scene free = weightless_scene(config, 2, 3);
  config.occlusion = 0.5;
  const Scene asked = weightless_scene(config, 2, 3);
  std::vector<Eigen::Vector3d> a, b;
  for (const Instance& i : free.instances)
    if (i.is_specimen) a.push_back(i.world_from_object.translation_m);
  for (const Instance& i : asked.instances)
    if (i.is_specimen) b.push_back(i.world_from_object.translation_m);
  EXPECT_EQ(a, b);
}

TEST(StrawberryTargets, WhatCannotBeMetIsSaidOrRefused) {
  // A lone fruit, no leaf: nothing can hide it.
  StrawberriesSceneConfig config = small_stretch(1);
  config.occlusion = 0.9;
  config.views = 1;
  config.plant.leaf.count_min = config.plant.leaf.count_max = 1;
  config.swings_leaves = false;
  config.azimuth_spread_rad = 0.1;
  const Scene scene = weightless_scene(config, 3, 1);
  EXPECT_EQ(bed_trait(scene, "met", 0), 0);
  EXPECT_GT(bed_trait(scene, "visible", 0), 0.2);
  config.unmet = "refuse";
  try {
    weightless_scene(config, 3, 1);
    FAIL() << "it is met";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("occlusion"), std::string::npos) << error.what();
  }
  config.unmet = "ignore";
  EXPECT_THROW(weightless_scene(config, 3, 1), std::invalid_argument);
  config.unmet = "state";
  config.motion.wind.mean_speed_m_s = 2;
  EXPECT_THROW(weightless_scene(config, 3, 1), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
