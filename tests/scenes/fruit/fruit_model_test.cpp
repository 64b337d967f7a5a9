#include "scenes/fruit/fruit_model.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "sim/geometry/cube_sphere.h"
#include "sim/geometry/measure.h"

namespace cousin {
namespace {

TEST(FruitModel, TheRedShareIsCutExactlyThroughTriangles) {
  // A unit square of two triangles; red - 2 green runs from -1 at x = 0 to 1 at x = 1.
  Mesh mesh;
  mesh.vertices_m = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  const Rgbf green{0, 0.5F, 0};
  const Rgbf red{1, 0, 0};
  EXPECT_NEAR(red_share(mesh, {green, red, red, green}), 0.5, 1e-12);
  const Rgbf redder{0.5F, 0, 0};  // crosses at x = 2/3
  EXPECT_NEAR(red_share(mesh, {green, redder, redder, green}), 1.0 / 3, 1e-12);
  EXPECT_EQ(red_share(mesh, {red, red, red, red}), 1);
  EXPECT_EQ(red_share(mesh, {green, green, green, green}), 0);
  // One corner only: half of one triangle's height, a quarter of its area.
  EXPECT_NEAR(red_share(mesh, {green, red, green, green}), 0.25 / 2, 1e-12);
}

TEST(FruitModel, ATubeIsClosedAndHasTheVolumeOfItsPrism) {
  const Mesh mesh = tube({{0, 0, 0}, {0, 0, 0.5}, {0, 0, 1}}, {0.1, 0.1, 0.1}, 24);
  EXPECT_TRUE(check_watertight(mesh).ok) << check_watertight(mesh).problem;
  const double polygon = 0.5 * 24 * 0.01 * std::sin(2 * std::numbers::pi / 24);
  EXPECT_NEAR(mass_properties(mesh).volume_m3, polygon, 1e-12);
}

TEST(FruitModel, AShapeIsFittedToItsRatioAndVolume) {
  Mesh mesh = cube_sphere(20);
  fit_shape(mesh, 1.4, 2e-5);
  const std::vector<TrueTrait> traits = fruit_traits(mesh, 0.5, 0.02);
  EXPECT_NEAR(traits[0].value / traits[1].value, 1.4, 1e-9);
  EXPECT_NEAR(traits[2].value, 2e-5, 1e-14);
  EXPECT_LT(mass_properties(mesh).centroid_m.norm(), 1e-9);
}

TEST(FruitModel, ColoursReachTheShareAskedFor) {
  const Mesh mesh = cube_sphere(30);
  std::vector<double> early;
  for (const Eigen::Vector3d& p : mesh.vertices_m) early.push_back(-p.z());
  const auto color = [](std::size_t, double ripe) {
    const auto t = static_cast<float>(std::clamp(ripe, 0.0, 1.0));
    return Rgbf{0.5F, 0.4F * (1 - t), 0.1F};
  };
  // Red where 0.5 >= 0.8 (1 - t).
  for (const double share : {0.0, 0.1, 0.5, 0.9, 1.0}) {
    const std::vector<Rgbf> colors = color_to_share(mesh, early, 0.3, 1 - 0.5 / 0.8, share, color);
    EXPECT_NEAR(red_share(mesh, colors), share, 0.003) << share;  // half a row of cells
  }
}

TEST(FruitModel, HarmonicsOfNoStrengthAreASphereAndOfAnyStayStarShaped) {
  const Mesh mesh = cube_sphere(8);
  for (const double radius : harmonic_radii(mesh.vertices_m, 8, 0, Rng(1))) EXPECT_EQ(radius, 1);
  double sum = 0;
  for (const double radius : harmonic_radii(mesh.vertices_m, 8, 3, Rng(1))) {
    EXPECT_GE(radius, 0.3);
    sum += std::abs(radius - 1);
  }
  EXPECT_GT(sum / static_cast<double>(mesh.vertices_m.size()), 0.05);
}

TEST(FruitModel, ACutNormalHasTheSpreadStated) {
  Rng rng(3);
  double sum = 0;
  double squares = 0;
  constexpr int kCount = 20000;
  for (int i = 0; i < kCount; ++i) {
    const double x = cut_normal(rng, 5, 0.4);
    sum += x;
    squares += x * x;
  }
  const double mean = sum / kCount;
  // Five standard errors: 0.4 / sqrt(n), and 0.6 % of the spread for a cut normal.
  EXPECT_NEAR(mean, 5, 0.015);
  EXPECT_NEAR(std::sqrt(squares / kCount - mean * mean), 0.4, 0.012);
}

}  // namespace
}  // namespace cousin
