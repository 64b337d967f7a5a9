#include "scenes/apples/apple.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <stdexcept>

#include "sim/geometry/measure.h"

namespace cousin {
namespace {

TEST(Apple, ElongationMultipliesLengthOverWidthAtTheSameVolume) {
  for (const FruitFamily family : {FruitFamily::botanical, FruitFamily::harmonics}) {
    const FruitModel plain = make_apple({.family = family}, Rng(5));
    const FruitModel longer = make_apple({.family = family, .elongation = 1.3}, Rng(5));
    EXPECT_NEAR(trait(longer, "volume"), trait(plain, "volume"), 1e-9 * trait(plain, "volume"));
    EXPECT_NEAR(trait(longer, "length") / trait(longer, "diameter"),
                1.3 * trait(plain, "length") / trait(plain, "diameter"), 1e-6);
  }
}

TEST(Apple, IsClosedAndWeighsItsVolumeTimesItsDensity) {
  const FruitModel fruit = make_apple({.red_share = 0.6}, Rng(5));
  const MeshCheck check = check_watertight(fruit.flesh.model.mesh);
  EXPECT_TRUE(check.ok) << check.problem;
  const FruitSize drawn = draw_size(apple_cultivar("fuji"), Rng(5).fork("size"));
  EXPECT_NEAR(fruit.mass_kg, drawn.mass_kg, 1e-12);
  EXPECT_NEAR(trait(fruit, "volume"), drawn.mass_kg / drawn.density_kg_m3, 1e-11);
  EXPECT_NEAR(trait(fruit, "length") / trait(fruit, "diameter"), drawn.shape_index, 1e-9);
  EXPECT_NEAR(trait(fruit, "red_share"), 0.6, 0.005);
}

TEST(Apple, IsDentedAtBothEndsSoItsHullHoldsMore) {
  const FruitModel fruit = make_apple({}, Rng(6));
  const double hull_m3 = mass_properties(convex_hull(fruit.flesh.model.mesh.vertices_m)).volume_m3;
  // A cone 10 mm deep and 26 mm across is 0.6 % of such an apple.
  EXPECT_GT(hull_m3, 1.005 * trait(fruit, "volume"));
  EXPECT_LT(hull_m3, 1.10 * trait(fruit, "volume"));
  double highest = 0, lowest = 0;
  for (const Eigen::Vector3d& p : fruit.flesh.model.mesh.vertices_m) {
    highest = std::max(highest, p.z());
    lowest = std::min(lowest, p.z());
  }
  for (const Keypoint& k : fruit.flesh.model.keypoints) {
    if (k.name == "stalk_base") EXPECT_LT(k.in_object_m.z(), highest - 0.004);
    if (k.name == "calyx_centre") EXPECT_GT(k.in_object_m.z(), lowest + 0.003);
    if (k.name == "cut_point") EXPECT_GT(k.in_object_m.z(), fruit.stalk_base_m.z() + 0.01);
  }
}

TEST(Apple, MassesAndDensitiesAreThePublishedOnesWithinTheirIntervals) {
  const AppleCultivar& c = apple_cultivar("fuji");
  double sum = 0, squares = 0, density = 0;
  constexpr int kCount = 2000;
  for (std::uint64_t i = 0; i < kCount; ++i) {
    const FruitSize size = draw_size(c, Rng(1).fork(i));
    sum += size.mass_kg;
    squares += size.mass_kg * size.mass_kg;
    density += size.density_kg_m3;
  }
  const double mean_kg = sum / kCount;
  const double sigma_kg = std::sqrt(squares / kCount - mean_kg * mean_kg);
  // 245 g [KJFP 2014]; a coefficient of variation of 16-28 % [Zhang & Robson].
  EXPECT_NEAR(mean_kg, 0.245, 1.96 * sigma_kg / std::sqrt(kCount));
  EXPECT_GT(sigma_kg / mean_kg, 0.16);
  EXPECT_LT(sigma_kg / mean_kg, 0.28);
  // Volumes of 1.13 to 1.18 mL/g, mean 1.165.
  EXPECT_NEAR(1e6 / (density / kCount) / 1e3, 1.165, 0.003);
}

TEST(Apple, TapersToBothEndsSoThatItIsNotBoxy) {
  // Widths at 8 % of the length from the ends over the largest. An ellipsoid has 0.54 there; with
  // wide dents, whose rims stand far out, fruits had 0.75 and 0.68 and looked like boxes.
  constexpr int kFruits = 12;
  double top = 0, bottom = 0;
  for (std::uint64_t i = 0; i < kFruits; ++i) {
    const FruitModel fruit = make_apple({.grid = 40}, Rng(9).fork(i));
    double high = -1, low = 1, widest = 0, at_top = 0, at_bottom = 0;
    for (const Eigen::Vector3d& p : fruit.flesh.model.mesh.vertices_m) {
      high = std::max(high, p.z());
      low = std::min(low, p.z());
      widest = std::max(widest, p.head<2>().norm());
    }
    const double length_m = high - low;
    for (const Eigen::Vector3d& p : fruit.flesh.model.mesh.vertices_m) {
      const double r = p.head<2>().norm() / widest;
      if (std::abs(high - 0.08 * length_m - p.z()) < 0.02 * length_m) at_top = std::max(at_top, r);
      if (std::abs(low + 0.08 * length_m - p.z()) < 0.02 * length_m)
        at_bottom = std::max(at_bottom, r);
    }
    top += at_top / kFruits;
    bottom += at_bottom / kFruits;
  }
  EXPECT_LT(top, 0.73);
  EXPECT_LT(bottom, 0.66);
  EXPECT_GT(top, bottom);  // wider to the stalk
}

TEST(Apple, TheOtherFamilyIsOfTheSameSizeWithoutDents) {
  const FruitModel other = make_apple({.family = FruitFamily::harmonics}, Rng(7));
  EXPECT_TRUE(check_watertight(other.flesh.model.mesh).ok);
  const FruitSize drawn = draw_size(apple_cultivar("fuji"), Rng(7).fork("size"));
  EXPECT_NEAR(trait(other, "volume"), drawn.mass_kg / drawn.density_kg_m3, 1e-11);
}

TEST(Apple, WhatCannotBeIsRefused) {
  EXPECT_THROW(make_apple({.cultivar = "gala"}, Rng(1)), std::invalid_argument);
  EXPECT_THROW(make_apple({.red_share = -0.1}, Rng(1)), std::invalid_argument);
  EXPECT_THROW(make_apple({.growth = 2}, Rng(1)), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
