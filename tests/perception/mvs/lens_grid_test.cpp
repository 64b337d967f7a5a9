#include "perception/mvs/lens_grid.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/perception/mvs/synthetic_seeds.h"

namespace cousin {
namespace {

class LensGridOfModel : public testing::TestWithParam<LensModel> {};

TEST_P(LensGridOfModel, DiffersFromTheLensByLessThanAHundredthOfAPixel) {
  const Camera camera = synthetic_camera(GetParam(), 640, 480, 540);
  const auto ray_at = [&](const Eigen::Vector2d& pixel) -> std::optional<Eigen::Vector2d> {
    const auto ray = unproject(camera, pixel);
    return ray ? std::optional<Eigen::Vector2d>(ray->head<2>() / ray->z()) : std::nullopt;
  };
  const LensGrid grid({0, 0, 640, 480}, ray_at);
  double worst_px = 0;
  for (int y = 3; y < 480; y += 13) {
    for (int x = 2; x < 640; x += 11) {
      const Eigen::Vector2f ray = grid(static_cast<float>(x), static_cast<float>(y));
      const auto pixel = project(camera, ray.cast<double>().homogeneous());
      ASSERT_TRUE(pixel.has_value());
      worst_px = std::max(worst_px, (*pixel - Eigen::Vector2d(x, y)).norm());
    }
  }
  // Cubics over 16 px leave little of the bend of these lenses.
  EXPECT_LT(worst_px, 0.01);
}

INSTANTIATE_TEST_SUITE_P(EveryLens, LensGridOfModel,
                         testing::Values(LensModel::pinhole, LensModel::opencv5, LensModel::opencv8,
                                         LensModel::opencv12, LensModel::kannala_brandt4),
                         [](const auto& param) { return std::string(to_string(param.param)); });

TEST(LensGrid, OutsideAndWhereTheMapHasNoValueIsNaN) {
  // Nodes 16 px apart; a cubic asks the two on each side.
  const LensGrid grid({10, 20, 64, 32},
                      [](const Eigen::Vector2d& p) -> std::optional<Eigen::Vector2d> {
                        return p.x() > 45 ? std::nullopt : std::optional<Eigen::Vector2d>(2 * p);
                      });
  EXPECT_FLOAT_EQ(grid(15.5F, 25.25F).x(), 31);
  EXPECT_FLOAT_EQ(grid(15.5F, 25.25F).y(), 50.5);
  EXPECT_TRUE(std::isnan(grid(9, 25).x()));
  EXPECT_TRUE(std::isnan(grid(15, 19).x()));
  EXPECT_TRUE(std::isnan(grid(50, 25).x()));
  EXPECT_TRUE(std::isnan(grid(std::nanf(""), 25).x()));
}

}  // namespace
}  // namespace cousin
