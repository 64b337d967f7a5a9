#include "sim/geometry/cube_sphere.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sim/geometry/gradient_noise.h"
#include "sim/geometry/measure.h"

namespace cousin {
namespace {

TEST(CubeSphere, IsClosedOutwardAndNearlyASphere) {
  const int grid = 24;
  const Mesh mesh = cube_sphere(grid);
  EXPECT_EQ(mesh.vertices_m.size(), static_cast<std::size_t>(6 * grid * grid + 2));
  EXPECT_TRUE(check_watertight(mesh).ok);
  // An inscribed polyhedron of cells h wide lacks about h^2 / 4 of the volume.
  const double cell = std::numbers::pi / 2 / grid;
  const double sphere = 4.0 / 3 * std::numbers::pi;
  EXPECT_LT(mass_properties(mesh).volume_m3, sphere);
  EXPECT_GT(mass_properties(mesh).volume_m3, sphere * (1 - cell * cell / 2));
}

TEST(CubeSphere, NeedsACell) { EXPECT_THROW(cube_sphere(0), std::invalid_argument); }

TEST(Noise, IsZeroOnTheLatticeBoundedAndContinuous) {
  EXPECT_EQ(noise3({3, -4, 5}, 7), 0);
  double most = 0;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d p(0.137 * i, 0.071 * i - 300, -0.053 * i);
    const double n = noise3(p, 7);
    most = std::max(most, std::abs(n));
    // The gradient of Perlin's noise stays below 4.
    EXPECT_NEAR(noise3(p + Eigen::Vector3d(1e-7, 0, 0), 7), n, 4e-7);
  }
  EXPECT_LE(most, 1.1);
  EXPECT_GT(most, 0.5);
}

TEST(Noise, KeysGiveOtherFields) {
  const Eigen::Vector3d p(0.3, 1.7, -2.2);
  EXPECT_NE(noise3(p, 1), noise3(p, 2));
}

}  // namespace
}  // namespace cousin
