#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sim/plant/plant.h"

namespace cousin {
namespace {

/// A stem, a leaf on it, and a leaf that has not come yet.
Plant small_plant() {
  Plant plant;
  plant.name = "test";
  AxisGrowth growth;
  growth.length_m = 0.05;
  Organ& stem = add_organ(plant, OrganKind::stem, "stem", -1, 0);
  stem.line = grow_axis(growth);
  stem.surface = tube_surface(stem.line, 8);
  growth.start_m = {0, 0, 0.05};
  growth.heading = Eigen::Vector3d::UnitX();
  Organ& leaf = add_organ(plant, OrganKind::blade, "leaf 1", 0, 1);
  leaf.look = 1;
  leaf.line = grow_axis(growth);
  leaf.surface = blade_surface(LineWalk(leaf.line, Eigen::Vector3d::UnitZ()), {}, 10, 4);
  add_organ(plant, OrganKind::blade, "leaf 2", 0, 2).look = 1;
  return plant;
}

TEST(PlantModel, HasAPartForEachOrganThereOrNot) {
  const Plant plant = small_plant();
  const PlantModel made = plant_model(plant);
  EXPECT_EQ(made.model.part_names, (std::vector<std::string>{"stem", "leaf 1", "leaf 2"}));
  EXPECT_EQ(made.part_looks, (std::vector<int>{0, 1, 1}));
  ASSERT_EQ(made.model.triangle_part.size(), made.model.mesh.triangles.size());
  std::vector<std::size_t> counts(3);
  for (const std::uint16_t part : made.model.triangle_part) ++counts.at(part);
  EXPECT_EQ(counts[0], plant.organs[0].surface.mesh.triangles.size());
  EXPECT_EQ(counts[1], plant.organs[1].surface.mesh.triangles.size());
  EXPECT_EQ(counts[2], 0U);
}

TEST(PlantModel, TraitsAreThoseOfTheSurfaces) {
  const Plant plant = small_plant();
  EXPECT_EQ(leaf_count(plant), 1);
  EXPECT_EQ(leaf_count(plant, 0.049), 1);  // it is 50 mm long
  EXPECT_EQ(leaf_count(plant, 0.051), 0);
  EXPECT_DOUBLE_EQ(leaf_area_m2(plant), surface_area_m2(plant.organs[1].surface.mesh));
  // The stem's end is a cap half a radius high.
  EXPECT_NEAR(height_m(plant), 0.05 + 0.5 * 0.001, 1e-12);
  EXPECT_NEAR(line_length_m(plant.organs[0]), 0.05, 1e-15);
  EXPECT_EQ(line_length_m(plant.organs[2]), 0);
}

TEST(PlantModel, AnInsertionAngleIsThatBetweenTheLines) {
  const Plant plant = small_plant();
  EXPECT_NEAR(insertion_angle_rad(plant, plant.organs[1]), std::numbers::pi / 2, 1e-12);
  EXPECT_TRUE(std::isnan(insertion_angle_rad(plant, plant.organs[0])));  // grows on nothing
  EXPECT_TRUE(std::isnan(insertion_angle_rad(plant, plant.organs[2])));  // is not there
}

TEST(PlantModel, RefusesBrokenTopology) {
  Plant orphan = small_plant();
  orphan.organs[1].parent = 2;  // comes after it
  EXPECT_THROW(validate(orphan), std::invalid_argument);
  Plant twins = small_plant();
  twins.organs[2].name = "leaf 1";
  EXPECT_THROW(validate(twins), std::invalid_argument);
  Plant moved = small_plant();
  std::swap(moved.organs[1], moved.organs[2]);
  EXPECT_THROW(validate(moved), std::invalid_argument);
  Plant torn = small_plant();
  torn.organs[0].surface.mesh.vertices_m[3].x() = std::nan("");
  EXPECT_THROW(plant_model(torn), std::invalid_argument);
}

TEST(Phyllotaxis, TwoRowsAndDivergence) {
  const Phyllotaxis grass{.first_rad = 0.3, .divergence_rad = std::numbers::pi};
  EXPECT_DOUBLE_EQ(azimuth_rad(grass, 0, 0), 0.3);
  EXPECT_DOUBLE_EQ(azimuth_rad(grass, 2, 0), 0.3 + 2 * std::numbers::pi);
  const Phyllotaxis wild{.spread_rad = 0.1};
  EXPECT_DOUBLE_EQ(azimuth_rad(wild, 1, -2), 2.39996 - 0.2);
}

}  // namespace
}  // namespace cousin
