#include "perception/stem/plant_height.h"

#include <gtest/gtest.h>

#include "tests/perception/stem/made_stem.h"

namespace cousin {
namespace {

constexpr double kRoot_m = 0.9, kTop_m = 0.5, kCamera_m = 0.35;

/// A rectified depth image of flat soil and a board of leaf 0.06 m wide and kTop_m high at the
/// root; behind it, farther than reach, a taller one.
PairDepth made_depth() {
  PairDepth depth;
  depth.camera = {LensModel::pinhole, 640, 480, 350, 350, 319.5, 239.5, {}, {}};
  depth.rectified_from_left = Eigen::Matrix3d::Identity();
  depth.depth_m = Image<float>(640, 480, std::numeric_limits<float>::quiet_NaN());
  depth.green = Image<std::uint8_t>(640, 480);
  const auto board = [&](int x, int y, double z_m, double half_m, double high_m) {
    const double X = (x - 319.5) / 350 * z_m, up_m = kCamera_m - (y - 239.5) / 350 * z_m;
    return std::abs(X) < half_m && up_m > 0 && up_m < high_m;
  };
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) {
      if (board(x, y, kRoot_m, 0.03, kTop_m)) {
        depth.depth_m(x, y) = static_cast<float>(kRoot_m);
        depth.green(x, y) = 255;
      } else if (board(x, y, 2.5, 0.4, 1.5)) {
        depth.depth_m(x, y) = 2.5F;
        depth.green(x, y) = 255;
      } else if (y > 245) {
        depth.depth_m(x, y) = static_cast<float>(kCamera_m / ((y - 239.5) / 350));
      }
    }
  }
  return depth;
}

TEST(HeightAboveGround, IsThatOfTheBoardAndNotOfWhatIsBehind) {
  const PlantHeight height =
      height_above_ground(made_depth(), {0, kCamera_m, kRoot_m}, 0.001, 0.01);
  ASSERT_TRUE(height.why_none.empty()) << height.why_none;
  EXPECT_NEAR(height.height_m, kTop_m, 0.004);  // a pixel and a half
  const auto up = ground_up(made_depth(), {0, kCamera_m, kRoot_m});
  ASSERT_TRUE(up.has_value());
  EXPECT_NEAR(-up->y(), 1, 1e-4);
  EXPECT_GT(height.sigma_m, 0.005);
}

TEST(HeightAboveGround, SaysWhatItLacks) {
  PairDepth depth = made_depth();
  depth.green = Image<std::uint8_t>(640, 480);
  EXPECT_NE(height_above_ground(depth, {0, kCamera_m, kRoot_m}, 0.001, 0.01).why_none.find("leaf"),
            std::string::npos);
  depth = made_depth();
  for (std::uint8_t& green : depth.green) green = 255;
  EXPECT_NE(height_above_ground(depth, {0, kCamera_m, kRoot_m}, 0.001, 0.01).why_none.find("soil"),
            std::string::npos);
}

TEST(HeightByGreen, FollowsTheGreenFromTheStemToTheTop) {
  const EyePair eyes = made_eyes();
  const std::vector<Eigen::Vector3d> line = {{0, 0.2, 0.9}, {0, 0.15, 0.9}, {0, -0.25, 0.9}};
  Image<Rgb8> images[2] = {Image<Rgb8>(1280, 720, {120, 90, 60}),
                           Image<Rgb8>(1280, 720, {120, 90, 60})};
  EyeNode root[2], node[2];
  for (int eye = 0; eye < 2; ++eye) {
    Eigen::Vector2d seen[3];
    for (std::size_t k = 0; k < 3; ++k)
      seen[k] = eye == 0 ? *eyes.left.project(line[k])
                         : *eyes.right.project(eyes.right_from_left * line[k]);
    root[eye].pixel_px = seen[0];
    node[eye].pixel_px = seen[1];
    for (int y = static_cast<int>(seen[2].y()); y <= static_cast<int>(seen[0].y()); ++y) {
      for (int x = -4; x <= 4; ++x)
        images[eye](static_cast<int>(seen[0].x()) + x, y) = {60, 140, 40};
    }
  }
  const PlantHeight height = height_by_green(eyes, images[0], images[1], root, node);
  ASSERT_TRUE(height.why_none.empty()) << height.why_none;
  EXPECT_NEAR(height.height_m, 0.45, 0.012);  // a pixel of disparity is 10 mm of depth
  root[0].pixel_px = root[1].pixel_px;
  EXPECT_FALSE(height_by_green(eyes, images[0], images[1], root, node).why_none.empty());
}

}  // namespace
}  // namespace cousin
