#include "perception/ngp/occupancy.h"

#include <gtest/gtest.h>

#include <numeric>

namespace cousin::ngp {
namespace {

Occupancy grid_of(const NgpVolume& volume, int resolution, std::uint8_t filled) {
  Occupancy grid;
  grid.resolution = resolution;
  grid.filled.assign(grid.cells_of_cube() * static_cast<std::size_t>(volume.cascades), filled);
  return grid;
}

TEST(Occupancy, CellsMiddlesLieInTheirCubes) {
  NgpVolume volume;
  volume.cascades = 3;
  const Occupancy grid = grid_of(volume, 8, 0);
  EXPECT_TRUE(cell_middle(grid, 0).isApprox(Eigen::Vector3f::Constant(-0.4375F)));
  const Eigen::Vector3f last = cell_middle(grid, grid.filled.size() - 1);
  EXPECT_TRUE(last.isApprox(Eigen::Vector3f::Constant(1.75F)));
  EXPECT_EQ(cube_of(volume, last), 2);
  EXPECT_EQ(cube_of(volume, {2.5F, 0, 0}), 3);
}

TEST(Occupancy, RaysSampleFilledCellsOnlyAndStepThroughThemWhole) {
  NgpVolume volume;
  Occupancy grid = grid_of(volume, 8, 0);
  // A slab of cells, x from 0 to 1/8.
  for (std::size_t cell = 0; cell < grid.filled.size(); ++cell) grid.filled[cell] = cell % 8 == 4;
  MarchConfig config;
  config.shortest = 0.002;
  std::vector<RaySample> samples;
  march(volume, grid, config, {-2, 0.01F, 0.02F}, {1, 0, 0}, 0, samples);
  ASSERT_FALSE(samples.empty());
  float length = 0;
  for (const RaySample& sample : samples) {
    EXPECT_GE(sample.at.x(), -1e-5F);
    EXPECT_LT(sample.at.x(), 0.125F);
    length += sample.length;
  }
  EXPECT_NEAR(length, 0.125, 0.0041) << "up to a step at either face";
}

// From so far away a step of 0.003 is less than what floats tell apart.
TEST(Occupancy, AStepThatAFloatDoesNotTellApartEndsTheRay) {
  const NgpVolume volume;
  std::vector<RaySample> samples;
  MarchConfig config;
  config.shortest = 0.003;
  config.cone = 0;
  for (const std::uint8_t filled : {0, 1}) {
    march(volume, grid_of(volume, 8, filled), config, {-1e5F, 0, 0}, {1, 0, 0}, 0, samples);
    EXPECT_LE(samples.size(), 1U);
  }
}

TEST(Occupancy, RaysThatMissOrPointAwayHaveNoSamples) {
  NgpVolume volume;
  volume.cascades = 2;
  const Occupancy grid = grid_of(volume, 8, 1);
  std::vector<RaySample> samples;
  march(volume, grid, {}, {-3, 0, 0}, {-1, 0, 0}, 0, samples);
  EXPECT_TRUE(samples.empty());
  march(volume, grid, {}, {-3, 5, 0}, {1, 0, 0}, 0, samples);
  EXPECT_TRUE(samples.empty());
  march(volume, grid, {}, {-3, 0, 0}, {1, 0, 0}, 0, samples);
  float length = 0;
  for (const RaySample& sample : samples) length += sample.length;
  EXPECT_NEAR(length, 2, 0.02) << "the outer cube's side";
}

}  // namespace
}  // namespace cousin::ngp
