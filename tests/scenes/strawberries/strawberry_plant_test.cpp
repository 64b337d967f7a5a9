#include "scenes/strawberries/strawberry_plant.h"

#include <gtest/gtest.h>

#include <numbers>

#include "sim/geometry/measure.h"
#include "tests/places/source_words.h"

namespace cousin {
namespace {

const Organ& organ_named(const Plant& plant, const std::string& name) {
  for (const Organ& organ : plant.organs) {
    if (organ.name == name) return organ;
  }
  throw std::logic_error("no organ " + name);
}

TEST(StrawberryPlant, EveryNumberHasItsSourceWord) {
  for (const char* file : {"plant.toml", "truss.toml", "varieties.toml", "bed.toml"})
    expect_sourced(std::string("strawberries/") + file);
}

TEST(StrawberryPlant, OrgansHaveTheSameIdsOnEveryPlant) {
  const Plant a = grow_strawberry_plant(strawberry_plant(), {}, Rng(1));
  const Plant b = grow_strawberry_plant(strawberry_plant(), {}, Rng(2));
  EXPECT_NO_THROW(validate(a));
  ASSERT_EQ(a.organs.size(), b.organs.size());
  for (std::size_t i = 0; i < a.organs.size(); ++i) {
    EXPECT_EQ(a.organs[i].name, b.organs[i].name);
    EXPECT_EQ(a.organs[i].parent, b.organs[i].parent);
  }
}

TEST(StrawberryPlant, EveryLeafHasThreeLeafletsOfPublishedShareOfSizes) {
  const auto& l = strawberry_plant().leaf;
  const Plant plant = grow_strawberry_plant(strawberry_plant(), {}, Rng(3));
  int leaves = 0;
  for (const Organ& organ : plant.organs) {
    if (organ.kind != OrganKind::petiole || !organ.name.starts_with("leaf ") || !is_there(organ))
      continue;
    ++leaves;
    const auto middle = static_cast<std::size_t>(organ.id) + 1;
    ASSERT_TRUE(is_there(plant.organs[middle]) && is_there(plant.organs[middle + 1]) &&
                is_there(plant.organs[middle + 2]));
    const double length_m = line_length_m(plant.organs[middle]);
    // Steps of equal length: exact to rounding.
    EXPECT_NEAR(line_length_m(plant.organs[middle + 1]), l.side_share * length_m, 1e-12);
    EXPECT_NEAR(line_length_m(plant.organs[middle + 2]), l.side_share * length_m, 1e-12);
  }
  EXPECT_GE(leaves, l.count_min);
  EXPECT_LE(leaves, l.count_max);
}

TEST(StrawberryPlant, OldLeavesLeanFartherOutThanYoungOnes) {
  const Plant plant = grow_strawberry_plant(strawberry_plant(), {}, Rng(4));
  const auto lean = [&](const Organ& petiole) {
    const auto& p = petiole.line.points_m;
    return (p.back() - p.front()).head<2>().norm() / (p.back() - p.front()).norm();
  };
  EXPECT_GT(lean(organ_named(plant, "leaf 1 petiole")), 0.7);
  EXPECT_LT(lean(organ_named(plant, "leaf 10 petiole")), 0.6);
}

TEST(StrawberryPlant, FlowersHaveFivePetals) {
  StrawberryPlantConfig config = strawberry_plant();
  config.flower.mean = 10;  // three come
  const Plant plant = grow_strawberry_plant(config, {}, Rng(5));
  const Organ& petals = organ_named(plant, "flower 1 petals");
  ASSERT_TRUE(is_there(petals));
  // Ten rows and six columns of two triangles each.
  EXPECT_EQ(petals.surface.mesh.triangles.size(), 5U * 10 * 6 * 2);
  // The receptacle and each anther are closed balls: Euler's characteristic 2 a body.
  const Mesh& middle = organ_named(plant, "flower 1 middle").surface.mesh;
  EXPECT_TRUE(check_watertight(middle).ok);
  EXPECT_EQ(middle.vertices_m.size() - middle.triangles.size() / 2,
            2U * static_cast<std::size_t>(1 + config.flower.anthers));
}

TEST(StrawberryPlant, WhatHasNoFreePoseIsNotThere) {
  const IsFree nowhere = [](const Mesh&) { return false; };
  const Plant plant = grow_strawberry_plant(strawberry_plant(), nowhere, Rng(6));
  for (const Organ& organ : plant.organs) EXPECT_EQ(is_there(organ), organ.name == "crown");
}

TEST(StrawberryPlant, ARunnerBearsADaughter) {
  StrawberryPlantConfig config = strawberry_plant();
  config.runner.share = 1;
  const Plant plant = grow_strawberry_plant(config, {}, Rng(7));
  const Organ& runner = organ_named(plant, "runner");
  ASSERT_TRUE(is_there(runner));
  const Organ& leaf = organ_named(plant, "daughter leaf 1 petiole");
  ASSERT_TRUE(is_there(leaf));
  EXPECT_EQ(leaf.parent, runner.id);
  EXPECT_LT((leaf.line.points_m.front() - runner.line.points_m.back()).norm(), 1e-12);
}

TEST(StrawberryPlant, ConfigurationsThatCannotGrowAreRefusedByName) {
  const auto message = [](const auto& change) {
    StrawberryPlantConfig config = strawberry_plant();
    change(config);
    try {
      validate(config);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(message([](auto& c) { c.leaf.count_min = 30; }).find("count_min"), std::string::npos);
  EXPECT_NE(message([](auto& c) { c.leaf.albedo = {1}; }).find("colour"), std::string::npos);
  EXPECT_NE(message([](auto& c) { c.surface.columns = 7; }).find("columns"), std::string::npos);
  EXPECT_NE(message([](auto& c) { c.leaf.petiole_m = -1; }).find("leaf.petiole_m"),
            std::string::npos);
}

}  // namespace
}  // namespace cousin
