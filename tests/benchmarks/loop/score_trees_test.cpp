// Count and yield of a tree against the fruits that hang in its place.
#include "benchmarks/loop/score_trees.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "benchmarks/loop/score_boxes.h"
#include "tests/benchmarks/loop/row_value.h"
#include "tests/sim/physics/solids.h"

namespace cousin {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

/// A tree at the origin, and cubes of 0.08 m: two in its place, one beside it, of a neighbour.
SceneTruth small_orchard() {
  SceneTruth truth;
  truth.scene.models.push_back({.name = "cube", .mesh = box_solid({0.08, 0.08, 0.08})});
  Instance tree;
  tree.id = 0;
  tree.name = tree.category = "tree";
  tree.traits = {{"place_along", "m", 1.0}, {"place_across", "m", 3.0}};
  truth.scene.instances.push_back(tree);
  const double masses_kg[] = {0.2, 0.3, 0.4};
  const Eigen::Vector3d places_m[] = {{0.1, 0.2, 1}, {-0.4, 0, 2}, {0.7, 0, 1}};
  for (int i = 0; i < 3; ++i) {
    Instance fruit;
    fruit.id = 1 + i;
    fruit.name = "apple " + std::to_string(i);
    fruit.is_specimen = true;
    fruit.world_from_object.translation_m = places_m[i];
    fruit.traits = {{"mass", "kg", masses_kg[i]}, {"redness", "1", 0.5}};
    truth.scene.instances.push_back(fruit);
  }
  return truth;
}

SpecimenTraits fruit_at(int instance, const Eigen::Vector3d& at_m, double mass_kg) {
  SpecimenTraits fruit;
  fruit.instance = instance;
  fruit.status = TraitStatus::ok;
  fruit.centroid_in_world_m = at_m;
  fruit.traits = {{"mass", "kg", mass_kg, 0.01}};
  return fruit;
}

/// One fruit found, one missed, one of the first counted twice, and one of nothing.
Estimate counted_orchard() {
  Estimate estimate;
  estimate.traits = {fruit_at(0, {0.11, 0.2, 1}, 0.21), fruit_at(1, {0.16, 0.2, 1}, 0.18),
                     fruit_at(2, {0, 0, 0.3}, 0.2)};
  SpecimenTraits tree;
  tree.instance = 3;
  tree.status = TraitStatus::ok;
  tree.traits = {{"fruit_count", "1", 3.5, 0.5}, {"yield", "kg", 0.65, 0.1}};
  estimate.traits.push_back(tree);
  return estimate;
}

TEST(ScoreTrees, FruitsOfThePlaceCountAndEachOnce) {
  const SceneTruth truth = small_orchard();
  const Estimate estimate = counted_orchard();
  EXPECT_EQ(traits_of_estimate(estimate), TraitsOf::trees);
  const SeedsScores scores = score_estimate(TraitsOf::trees, truth, estimate, {});
  EXPECT_EQ(value_of(scores.rows, "fruits.found"), 1);
  EXPECT_EQ(value_of(scores.rows, "fruits.missed"), 1);
  EXPECT_EQ(value_of(scores.rows, "fruits.doubled"), 1);
  EXPECT_EQ(value_of(scores.rows, "fruits.spurious"), 1);
  EXPECT_EQ(value_of(scores.rows, "fruits.beside"), 0);
  ASSERT_EQ(scores.specimens.size(), 4U);  // two masses, and the tree's count and yield
  EXPECT_EQ(scores.specimens[0].trait, "mass");
  EXPECT_EQ(scores.specimens[0].measured, 0.21);
  EXPECT_EQ(scores.specimens[1].status, ScoreStatus::not_solved);
  const SpecimenRow& count = scores.specimens[2];
  EXPECT_EQ(count.cultivar, "tree");
  EXPECT_EQ(count.truth, 2);
  EXPECT_EQ(count.measured, 3.5);
  EXPECT_DOUBLE_EQ(scores.specimens[3].truth, 0.5);
  EXPECT_EQ(scores.specimens[3].measured, 0.65);
}

TEST(ScoreTrees, WhatIsFarOffIsNoDoubleAndANeighboursFruitIsBeside) {
  Estimate estimate;
  estimate.traits = {fruit_at(0, {0.15, 0.2, 1}, 0.2),  // 5 cm off: the fruit is missed
                     fruit_at(1, {0.69, 0, 1}, 0.4)};   // of the neighbour
  const SeedsScores scores = score_trees(small_orchard(), estimate, {});
  EXPECT_EQ(value_of(scores.rows, "fruits.found"), 0);
  EXPECT_EQ(value_of(scores.rows, "fruits.doubled"), 0);
  EXPECT_EQ(value_of(scores.rows, "fruits.spurious"), 1);
  EXPECT_EQ(value_of(scores.rows, "fruits.beside"), 1);
}

TEST(ScoreTrees, WithoutAnEstimateNothingIsSolved) {
  const SeedsScores scores = score_trees(small_orchard(), {}, {});
  EXPECT_EQ(value_of(scores.rows, "fruits.missed"), 2);
  for (const SpecimenRow& row : scores.specimens) EXPECT_EQ(row.status, ScoreStatus::not_solved);
}

TEST(ScoreTrees, ASceneWithoutATreeIsRefusedAndSoIsAnotherUnit) {
  SceneTruth truth = small_orchard();
  Estimate estimate = counted_orchard();
  estimate.traits[0].traits[0].unit = "g";
  EXPECT_THAT([&] { score_trees(truth, estimate, {}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("mass is in g")));
  truth.scene.instances[0].traits.clear();
  EXPECT_THAT([&] { score_trees(truth, {}, {}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("place_along")));
  truth.scene.instances.erase(truth.scene.instances.begin());
  EXPECT_THAT([&] { score_trees(truth, {}, {}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("no instance \"tree\"")));
}

}  // namespace
}  // namespace cousin
