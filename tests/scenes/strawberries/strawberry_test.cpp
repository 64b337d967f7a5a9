#include "scenes/strawberries/strawberry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <set>
#include <stdexcept>

#include "sim/geometry/measure.h"

namespace cousin {
namespace {

Eigen::Vector3d keypoint(const FruitModel& fruit, const std::string& name) {
  for (const Keypoint& k : fruit.flesh.model.keypoints) {
    if (k.name == name) return k.in_object_m;
  }
  ADD_FAILURE() << name;
  return {};
}

TEST(Strawberry, ElongationMultipliesLengthOverWidthAtTheSameVolume) {
  for (const FruitFamily family : {FruitFamily::botanical, FruitFamily::harmonics}) {
    const FruitModel plain = make_strawberry({.family = family}, Rng(5));
    const FruitModel longer = make_strawberry({.family = family, .elongation = 1.3}, Rng(5));
    EXPECT_NEAR(trait(longer, "volume"), trait(plain, "volume"), 1e-9 * trait(plain, "volume"));
    EXPECT_NEAR(trait(longer, "length") / trait(longer, "diameter"),
                1.3 * trait(plain, "length") / trait(plain, "diameter"), 1e-6);
  }
}

TEST(Strawberry, IsClosedAndItsTraitsAreThoseDrawn) {
  for (const std::string& variety : strawberry_varieties()) {
    const FruitModel fruit = make_strawberry({.variety = variety}, Rng(5));
    const MeshCheck check = check_watertight(fruit.flesh.model.mesh);  // flesh and achenes
    EXPECT_TRUE(check.ok) << variety << ": " << check.problem;
    EXPECT_TRUE(check_watertight(fruit.stalk.model.mesh).ok);
    const FruitSize drawn = draw_size(strawberry_variety(variety), Rng(5).fork("size"));
    EXPECT_NEAR(fruit.mass_kg, drawn.mass_kg, 1e-12);
    EXPECT_NEAR(trait(fruit, "volume"), drawn.mass_kg / drawn.density_kg_m3, 1e-12);
    // A caliper in 36 directions, of the shape with its dimples: exactly as fitted.
    EXPECT_NEAR(trait(fruit, "length") / trait(fruit, "diameter"), drawn.shape_index, 1e-9);
    // Its hull holds it, to what thinning leaves.
    EXPECT_GT(mass_properties(fruit.hull).volume_m3, 0.97 * trait(fruit, "volume"));
    EXPECT_LT(mass_properties(fruit.hull).volume_m3, 1.12 * trait(fruit, "volume"));
  }
}

TEST(Strawberry, KeypointsLieAtTipCalyxAndOnTheStalk) {
  const FruitModel fruit = make_strawberry({}, Rng(2));
  const double length_m = trait(fruit, "length");
  EXPECT_LT(keypoint(fruit, "tip").z(), -0.4 * length_m);
  EXPECT_GT(keypoint(fruit, "calyx_centre").z(), 0.25 * length_m);
  EXPECT_LT(keypoint(fruit, "calyx_centre").head<2>().norm(), 0.15 * trait(fruit, "diameter"));
  const double above_m = (keypoint(fruit, "cut_point") - keypoint(fruit, "calyx_centre")).norm();
  EXPECT_NEAR(above_m, strawberry_variety("benihoppe").cut_point_m, 0.001);  // along a bow
}

TEST(Strawberry, TheRedShareIsReachedAndGrowsFromTheTip) {
  for (const double share : {0.0, 0.2, 0.55, 0.9}) {
    const FruitModel fruit = make_strawberry({.red_share = share}, Rng(4));
    EXPECT_NEAR(trait(fruit, "red_share"), share, 0.005);
    if (!(share > 0)) continue;
    double red_z = 0, other_z = 0;
    int red = 0, other = 0;
    const ObjectModel& model = fruit.flesh.model;
    for (std::size_t t = 0; t < model.mesh.triangles.size(); ++t) {
      if (model.triangle_part[t] != 0) continue;
      const std::uint32_t k = model.mesh.triangles[t][0];
      const bool is_red = model.vertex_albedo[k].r >= 2 * model.vertex_albedo[k].g;
      (is_red ? red_z : other_z) += model.mesh.vertices_m[k].z();
      ++(is_red ? red : other);
    }
    EXPECT_LT(red_z / red, other_z / other);
  }
  EXPECT_EQ(trait(make_strawberry({.red_share = 1}, Rng(4)), "red_share"), 1);
}

TEST(Strawberry, TheSunnySideIsRedder) {
  const FruitModel fruit = make_strawberry({.red_share = 0.5, .to_sun = {0, 1, 0}}, Rng(9));
  double sunny = 0, shady = 0;
  const ObjectModel& model = fruit.flesh.model;
  for (std::size_t i = 0; i < model.mesh.vertices_m.size(); ++i) {
    const double red = model.vertex_albedo[i].r >= 2 * model.vertex_albedo[i].g ? 1 : 0;
    (model.mesh.vertices_m[i].y() > 0 ? sunny : shady) += red;
  }
  EXPECT_GT(sunny, 1.15 * shady);
}

TEST(Strawberry, AchenesKeepApartAndAreAsManyAsStated) {
  const StrawberryVariety& v = strawberry_variety("akihime");
  const StrawberryFlesh flesh =
      make_strawberry_flesh(v, FruitFamily::botanical, 1.5, 2e-5, v.grid, Rng(1));
  EXPECT_EQ(flesh.achenes.size(), static_cast<std::size_t>(v.achenes));
  int crowded = 0;
  for (std::size_t i = 0; i < flesh.achenes.size(); ++i) {
    double nearest = 1;
    for (std::size_t k = 0; k < flesh.achenes.size(); ++k) {
      if (k == i) continue;
      nearest = std::min(nearest, (flesh.mesh.vertices_m[flesh.achenes[i]] -
                                   flesh.mesh.vertices_m[flesh.achenes[k]])
                                      .norm());
    }
    if (nearest < v.achene_length_m) ++crowded;
  }
  // A spiral leaves each its place: only next to the tip may a few touch.
  EXPECT_LE(crowded, v.achenes / 25);
}

TEST(Strawberry, SepalsStayOutOfTheFlesh) {
  const FruitModel fruit = make_strawberry({.red_share = 0}, Rng(3));  // clasping
  const StrawberryVariety& v = strawberry_variety("benihoppe");
  const FruitSize drawn = draw_size(v, Rng(3).fork("size"));
  const StrawberryFlesh flesh =
      make_strawberry_flesh(v, FruitFamily::botanical, drawn.shape_index,
                            drawn.mass_kg / drawn.density_kg_m3, v.grid, Rng(3).fork("flesh"));
  for (const Eigen::Vector3d& p : fruit.calyx.model.mesh.vertices_m) {
    std::size_t nearest = 0;
    for (std::size_t i = 1; i < flesh.mesh.vertices_m.size(); ++i) {
      if ((flesh.mesh.vertices_m[i] - p).squaredNorm() <
          (flesh.mesh.vertices_m[nearest] - p).squaredNorm())
        nearest = i;
    }
    // They are kept 0.3 mm off by the nearest vertex's plane; curvature takes a little of it.
    EXPECT_GT(flesh.normals[nearest].dot(p - flesh.mesh.vertices_m[nearest]), 0);
  }
}

TEST(Strawberry, TheOtherFamilyHasTheSameSizeAndAnotherShape) {
  const FruitModel ours = make_strawberry({}, Rng(6));
  const FruitModel other = make_strawberry({.family = FruitFamily::harmonics}, Rng(6));
  EXPECT_TRUE(check_watertight(other.flesh.model.mesh).ok);
  EXPECT_NEAR(trait(ours, "volume"), trait(other, "volume"), 1e-12);
  EXPECT_NEAR(trait(ours, "length") / trait(ours, "diameter"),
              trait(other, "length") / trait(other, "diameter"), 1e-9);
  EXPECT_GT(std::abs(trait(ours, "area") / trait(other, "area") - 1), 1e-3);
}

TEST(Strawberry, IsTheSameFromTheSameSeed) {
  const FruitModel a = make_strawberry({.red_share = 0.4}, Rng(8));
  const FruitModel b = make_strawberry({.red_share = 0.4}, Rng(8));
  const FruitModel c = make_strawberry({.red_share = 0.4}, Rng(9));
  EXPECT_EQ(a.flesh.model.mesh.vertices_m, b.flesh.model.mesh.vertices_m);
  EXPECT_EQ(a.calyx.model.mesh.vertices_m, b.calyx.model.mesh.vertices_m);
  EXPECT_NE(a.mass_kg, c.mass_kg);
}

TEST(Strawberry, SizesHaveTheStatedMeansAndSpreads) {
  for (const std::string& name : strawberry_varieties()) {
    const StrawberryVariety& v = strawberry_variety(name);
    double sum = 0, squares = 0;
    constexpr int kCount = 2000;
    for (std::uint64_t i = 0; i < kCount; ++i) {
      const double mass_kg = draw_size(v, Rng(1).fork(i)).mass_kg;
      sum += mass_kg;
      squares += mass_kg * mass_kg;
    }
    const double mean_kg = sum / kCount;
    const double sigma_kg = std::sqrt(squares / kCount - mean_kg * mean_kg);
    // 95 %: 1.96 standard errors of the mean and, for the spread, sigma / sqrt(2 n).
    EXPECT_NEAR(mean_kg, v.mass_kg, 1.96 * v.cv_mass * v.mass_kg / std::sqrt(kCount)) << name;
    EXPECT_NEAR(sigma_kg, v.cv_mass * v.mass_kg,
                1.96 * v.cv_mass * v.mass_kg / std::sqrt(2.0 * kCount))
        << name;
  }
}

TEST(Strawberry, WhatCannotBeIsRefusedByName) {
  const auto refusal = [](const StrawberryConfig& config) {
    try {
      make_strawberry(config, Rng(1));
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(refusal({.variety = "elsanta"}), testing::HasSubstr("akihime"));
  EXPECT_THAT(refusal({.red_share = 1.2}), testing::HasSubstr("red_share is 1.2"));
  EXPECT_THAT(refusal({.growth = 0}), testing::HasSubstr("growth is 0"));
  EXPECT_THAT(refusal({.to_sun = {0, 0, 0}}), testing::HasSubstr("to_sun"));
}

}  // namespace
}  // namespace cousin
