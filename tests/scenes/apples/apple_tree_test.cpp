#include "scenes/apples/apple_tree.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <stdexcept>

#include "sim/geometry/measure.h"
#include "sim/physics/penetration.h"
#include "tests/places/source_words.h"
#include "tests/scenes/apples/small_orchard.h"

namespace cousin {
namespace {

using Eigen::Vector3d;
using testing::AllOf;
using testing::HasSubstr;

std::string refusal(const ApplesSceneConfig& config) {
  try {
    grow_scene_tree(config, Rng(1));
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(AppleTree, EveryNumberHasItsSourceWord) {
  expect_sourced("apples/orchard.toml");
  expect_sourced("apples/cultivars.toml");
}

TEST(AppleTree, IsPrunedAtItsGreatestHeight) {
  OrchardConfig config = orchard();
  config.tree.height_most_m = 2;
  const AppleTree tree = grow_apple_tree(config, 1, Rng(1));
  EXPECT_DOUBLE_EQ(tree.wood[0].line.points_m.back().z(), 2);
}

TEST(AppleTree, RangesOutOfOrderAreRefusedByName) {
  OrchardConfig config = orchard();
  config.shoot.spacing_spread = {1.5, 0.6};
  try {
    validate(config);
    ADD_FAILURE() << "taken";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("shoot.spacing_spread [1.5"));
  }
}

TEST(AppleTree, IsADwarfTreeThatStandsOnItsFoot) {
  const AppleTree tree = grow_apple_tree(orchard(), 4, Rng(1));
  EXPECT_LT(height_m(tree), 3.5);  // [Apples 2.1]
  EXPECT_GT(height_m(tree), 2.5);
  EXPECT_LT(tree.wood[0].line.points_m.front().norm(), 1e-9);
  EXPECT_GT(tree.leaves.size(), 2000U);
  for (std::size_t i = 1; i < tree.wood.size(); ++i) {
    const WoodAxis& axis = tree.wood[i];
    ASSERT_GE(axis.parent, 0);
    ASSERT_LT(axis.parent, static_cast<int>(i));
    const LineWalk walk(tree.wood[static_cast<std::size_t>(axis.parent)].line, Vector3d::UnitX());
    // Each grows on its parent's axis.
    EXPECT_LT((walk.at_share(axis.parent_share).point_m - axis.line.points_m.front()).norm(), 1e-9);
  }
}

TEST(AppleTree, BearsTheFruitsAskedForByTheirStalks) {
  ApplesSceneConfig config = small_orchard();
  config.sag = false;
  const GrownTree grown = grow_scene_tree(config, Rng(2));
  ASSERT_EQ(grown.tree.fruits.size() + static_cast<std::size_t>(grown.tree.rest.thinned), 12U);
  EXPECT_EQ(grown.tree.rest.thinned, 0);  // unbent, they hang where they were placed: clear
  for (const FruitPlace& fruit : grown.tree.fruits) {
    const auto& keypoints =
        grown.fruits[static_cast<std::size_t>(fruit.variant)].flesh.model.keypoints;
    const Vector3d tip = grown.tree.wood[static_cast<std::size_t>(fruit.axis)].line.points_m.back();
    for (const Keypoint& k : keypoints) {
      if (k.name != "cut_point") continue;
      // At the spur's end, or on the swollen bourse about it.
      EXPECT_LT((fruit.tree_from_fruit * k.in_object_m - tip).norm(),
                config.orchard.spur.bourse_m + 1e-9);
    }
  }
}

#if COUSIN_WITH_MUJOCO
TEST(AppleTree, BranchesBendUnderTheirFruitsToRestWithoutOverlaps) {
  const GrownTree grown = grow_scene_tree(small_orchard(), Rng(3));
  EXPECT_TRUE(grown.tree.rest.is_bent);
  EXPECT_EQ(grown.tree.rest.not_at_rest, 0);
  EXPECT_GT(grown.tree.rest.sag_m, 0.002);
  EXPECT_LT(grown.tree.rest.deepest_m, 5e-4);
  // A second look at what rest.deepest_m says: corners of one fruit's hull in another's.
  for (const FruitPlace& a : grown.tree.fruits) {
    const ConvexBody body(grown.fruits[static_cast<std::size_t>(a.variant)].hull);
    for (const FruitPlace& b : grown.tree.fruits) {
      if (&a == &b) continue;
      const Pose a_from_b = inverse(a.tree_from_fruit) * b.tree_from_fruit;
      for (const Vector3d& v : grown.fruits[static_cast<std::size_t>(b.variant)].hull.vertices_m)
        ASSERT_LT(body.depth_m(a_from_b * v, 0), 5e-4);
    }
  }
}

TEST(AppleTree, BranchesThatAreTooWeakBreakByName) {
  ApplesSceneConfig config = small_orchard();
  config.orchard.branch.strength_pa = 1e5;
  EXPECT_THAT(refusal(config), AllOf(HasSubstr("broke"), HasSubstr("branch.strength_pa")));
}
#endif

TEST(AppleTree, LeavesStandInNoFruit) {
  ApplesSceneConfig config = small_orchard();
  config.sag = false;
  const GrownTree grown = grow_scene_tree(config, Rng(4));
  for (const FruitPlace& fruit : grown.tree.fruits) {
    const ConvexBody body(grown.fruits[static_cast<std::size_t>(fruit.variant)].hull);
    for (const LeafPlace& leaf : grown.tree.leaves) {
      const Pose fruit_from_leaf = inverse(fruit.tree_from_fruit) * leaf.tree_from_leaf;
      if (fruit_from_leaf.translation_m.norm() > 0.25) continue;
      const auto& mesh = grown.leaves[static_cast<std::size_t>(leaf.variant)].model.mesh;
      double deepest = -1;
      for (const Vector3d& v : mesh.vertices_m)
        deepest = std::max(deepest, body.depth_m(fruit_from_leaf * v, -1));
      // Every fifth vertex is kept half a millimetre off; those between reach a little farther.
      EXPECT_LT(deepest, 5e-4);
    }
  }
}

TEST(AppleTree, WhatItCannotHoldIsRefusedByName) {
  ApplesSceneConfig config = small_orchard();
  config.fruits = 500;
  EXPECT_THAT(refusal(config), AllOf(HasSubstr("fruits = 500"), HasSubstr("room for")));
  config = small_orchard();
  config.heavier = 100;  // 25 kg: a stalk holds 2.5 kg
  EXPECT_THAT(refusal(config), AllOf(HasSubstr("its stalk holds"), HasSubstr("25.0")));
}

TEST(AppleTree, ZeroLeavesIsABareTreeWithItsFruits) {
  ApplesSceneConfig config = small_orchard();
  config.orchard.spur.leaves = 0;
  config.sag = false;
  const GrownTree grown = grow_scene_tree(config, Rng(5));
  EXPECT_TRUE(grown.tree.leaves.empty());
  EXPECT_EQ(grown.tree.fruits.size(), 12U);
}

TEST(AppleLeaf, IsAsLargeAsAFujiLeaf) {
  double sum_m2 = 0;
  constexpr int kLeaves = 30;
  for (std::uint64_t i = 0; i < kLeaves; ++i) {
    const PlantModel leaf = apple_leaf(orchard(), 1, Rng(1).fork(i));
    const Mesh& blade = leaf.model.mesh;
    double area_m2 = 0;
    for (std::size_t k = 0; k < blade.triangles.size(); ++k) {
      if (leaf.part_looks[leaf.model.triangle_part[k]] != kAppleBladeLook) continue;
      const auto& t = blade.triangles[k];
      const Vector3d& a = blade.vertices_m[t[0]];
      area_m2 += 0.5 * (blade.vertices_m[t[1]] - a).cross(blade.vertices_m[t[2]] - a).norm();
    }
    sum_m2 += area_m2;
  }
  // Leaves of apple have 20-35 cm2; two thirds of 78 by 44 mm is 23 cm2.
  EXPECT_GT(sum_m2 / kLeaves, 18e-4);
  EXPECT_LT(sum_m2 / kLeaves, 35e-4);
}

}  // namespace
}  // namespace cousin
