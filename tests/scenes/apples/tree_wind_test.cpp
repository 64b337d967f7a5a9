#include "scenes/apples/tree_wind.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <stdexcept>

#include "sim/plant/organ_surface.h"
#include "tests/scenes/apples/small_orchard.h"

namespace cousin {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

ApplesSceneConfig windy() {
  ApplesSceneConfig config = small_orchard();
  config.views = 2;
  config.wind.mean_speed_m_s = 4;
  config.orchard.sway.lead_s = 0.3;
  return config;
}

bool has_physics() { return COUSIN_WITH_MUJOCO != 0; }

std::string refusal(const ApplesSceneConfig& config) {
  try {
    build_apples_scene(config, Rng(1));
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

/// Farthest way of an instance's origin from where it is at rest.
double way_m(const Instance& instance) {
  double most = 0;
  for (const TimedPose& step : instance.motion) {
    most = std::max(
        most,
        (step.world_from_object.translation_m - instance.world_from_object.translation_m).norm());
  }
  return most;
}

TEST(TreeWind, BranchesMoveWithFruitsAndLeavesAndTheTrunkStands) {
  if (!has_physics()) GTEST_SKIP() << "WITH_MUJOCO is OFF";
  const Scene scene = build_apples_scene(windy(), Rng(1));
  EXPECT_TRUE(scene.instances[0].motion.empty());
  int moving_leaves = 0, fruits = 0;
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    if (instance.category == "leaf") moving_leaves += way_m(instance) > 1e-4;
    // A branch of metres sways by centimetres in 4 m/s, not by its length.
    EXPECT_LT(way_m(instance), 0.3) << instance.name;
    if (!instance.is_specimen) continue;
    ++fruits;
    ASSERT_FALSE(instance.motion.empty()) << instance.name;
    EXPECT_GT(way_m(instance), 0);
    for (std::size_t part = 1; part < 3; ++part) {  // calyx and stalk go with the flesh
      const Instance& other = scene.instances[i + part];
      ASSERT_EQ(other.motion.size(), instance.motion.size());
      for (std::size_t k = 0; k < other.motion.size(); ++k) {
        EXPECT_EQ(other.motion[k].world_from_object.translation_m,
                  instance.motion[k].world_from_object.translation_m);
      }
    }
  }
  EXPECT_GT(fruits, 0);
  EXPECT_GT(moving_leaves, 100);
}

TEST(TreeWind, MotionBeginsBeforeEachViewAndEndsAfterIt) {
  if (!has_physics()) GTEST_SKIP() << "WITH_MUJOCO is OFF";
  const Scene scene = build_apples_scene(windy(), Rng(2));
  for (const Instance& instance : scene.instances) {
    if (!instance.is_specimen) continue;
    for (const View& view : scene.views) {
      int near = 0;
      for (const TimedPose& step : instance.motion)
        near += std::abs(step.time_s - view.time_s) < 0.05;
      EXPECT_GE(near, 4) << instance.name;  // a sample each 0.02 s
    }
    for (std::size_t k = 1; k < instance.motion.size(); ++k)
      EXPECT_GT(instance.motion[k].time_s, instance.motion[k - 1].time_s);
  }
}

TEST(TreeWind, AHandMovesOneBranchAlone) {
  if (!has_physics()) GTEST_SKIP() << "WITH_MUJOCO is OFF";
  ApplesSceneConfig config = windy();
  config.wind.mean_speed_m_s = 0;
  config.push.force_n = 3;
  config.push.branch = 2;
  config.push.view = 1;
  const GrownTree grown = grow_scene_tree(config, Rng(3).fork("tree"));
  const Scene scene = build_apples_scene(config, Rng(3));
  std::size_t leaf = 0;
  double most = 0;
  for (const Instance& instance : scene.instances) {
    if (instance.category != "leaf") continue;
    const LeafPlace& place = grown.tree.leaves[leaf++];
    if (place_on_branch(grown.tree, place.axis, place.share).branch == config.push.branch) {
      most = std::max(most, way_m(instance));
    } else {
      EXPECT_TRUE(instance.motion.empty()) << instance.name;
    }
  }
  EXPECT_GT(most, 0.005);
}

TEST(TreeWind, IsTheSameOnAnyNumberOfThreads) {
  if (!has_physics()) GTEST_SKIP() << "WITH_MUJOCO is OFF";
  const auto build = [](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return build_apples_scene(windy(), Rng(4));
  };
  const Scene a = build(1), b = build(8);
  ASSERT_EQ(a.instances.size(), b.instances.size());
  for (std::size_t i = 0; i < a.instances.size(); ++i) {
    ASSERT_EQ(a.instances[i].motion.size(), b.instances[i].motion.size());
    for (std::size_t k = 0; k < a.instances[i].motion.size(); ++k) {
      const Pose &p = a.instances[i].motion[k].world_from_object,
                 &q = b.instances[i].motion[k].world_from_object;
      ASSERT_EQ(p.translation_m, q.translation_m);
      ASSERT_EQ(p.rotation.coeffs(), q.rotation.coeffs());
    }
  }
}

TEST(TreeWind, PiecesAreTheWholeWood) {
  const ApplesSceneConfig config = small_orchard();
  const GrownTree grown = grow_scene_tree(config, Rng(5));
  const PlantModel wood = tree_wood(grown.tree, config.orchard, 0, Rng(6));
  double area_m2 = 0;
  std::size_t triangles = 0;
  const std::vector<WoodPiece> pieces = cut_wood(grown.tree, wood.model, wood.part_looks);
  for (const WoodPiece& piece : pieces) {
    area_m2 += surface_area_m2(piece.model.mesh);
    triangles += piece.model.mesh.triangles.size();
    EXPECT_EQ(piece.part_materials.size(), piece.model.part_names.size());
  }
  EXPECT_EQ(triangles, wood.model.mesh.triangles.size());
  // The same triangles, summed in another order.
  EXPECT_NEAR(area_m2, surface_area_m2(wood.model.mesh), 1e-12);
  ASSERT_FALSE(pieces.front().model.part_names.empty());
  EXPECT_EQ(pieces.front().model.part_names.front(), "trunk");
}

TEST(TreeWind, WhatCannotBeMovedIsRefusedByName) {
  ApplesSceneConfig config = windy();
  config.sag = false;
  EXPECT_THAT(refusal(config), HasSubstr("sag must be true"));
  config = windy();
  config.push.force_n = 1;
  config.push.view = 2;
  EXPECT_THAT(refusal(config), HasSubstr(has_physics() ? "push.view is 2" : "WITH_MUJOCO"));
  config.push.view = 0;
  config.push.branch = 7;
  EXPECT_THAT(refusal(config), HasSubstr(has_physics() ? "push.branch is 7" : "WITH_MUJOCO"));
  config.push.force_n = 1e3;
  EXPECT_THAT(refusal(config), HasSubstr("push.force_n"));
}

TEST(TreeRest, ReadsBackBitByBitAndHostileTextIsRefused) {
  if (!has_physics()) GTEST_SKIP() << "WITH_MUJOCO is OFF";
  const ApplesSceneConfig config = small_orchard();
  std::vector<HangingBranch> branches;
  std::vector<SagResult> rests;
  grow_scene_tree(config, Rng(7), [&](const std::vector<HangingBranch>& these) {
    branches = these;
    return rests = settle_branches(these);
  });
  const std::string text = rests_to_text(rests);
  EXPECT_EQ(rests_to_text(rests_from_text(text, "some.tree", branches)), text);
  const auto read = [&](const std::string& bad) {
    try {
      rests_from_text(bad, "some.tree", branches);
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(read(""), HasSubstr("some.tree"));
  EXPECT_THAT(read(text.substr(0, text.size() / 2)), HasSubstr("some.tree"));
  EXPECT_THAT(read(text + "more"), HasSubstr("more stands after its end"));
  branches.pop_back();
  EXPECT_THAT(read(text), HasSubstr("another tree"));
}

}  // namespace
}  // namespace cousin
