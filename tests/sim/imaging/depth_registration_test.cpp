#include "sim/imaging/depth_registration.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace cousin {
namespace {

Camera camera(int width_px, int height_px, double focal_px) {
  Camera c;
  c.width_px = width_px;
  c.height_px = height_px;
  c.fx_px = c.fy_px = focal_px;
  c.cx_px = 0.5 * (width_px - 1);
  c.cy_px = 0.5 * (height_px - 1);
  return c;
}

Pose shifted(double x_m, double z_m = 0) {
  Pose other_from_depth;
  other_from_depth.translation_m = {x_m, 0, z_m};
  return other_from_depth;
}

TEST(DepthRegistration, TheSameCameraGivesTheSameImage) {
  Image<std::uint16_t> depth(40, 30);
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x)
      depth(x, y) = static_cast<std::uint16_t>((x + y) % 7 == 0 ? 0 : 500 + 10 * x + y);
  }
  const Camera c = camera(40, 30, 50);
  EXPECT_EQ(register_depth(depth, 0.001, c, c, {}), depth);
}

TEST(DepthRegistration, APointMovesByItsDisparityAndItsDepthByTheOffset) {
  Image<std::uint16_t> depth(40, 30);
  depth(20, 15) = 1000;
  const Camera c = camera(40, 30, 50);
  // 0.1 m to the side at 1 m: 5 px; the other camera stands 0.2 m further back, so 50/1.2.
  const Image<std::uint16_t> moved = register_depth(depth, 0.001, c, c, shifted(0.1));
  EXPECT_EQ(moved(25, 15), 1000);
  const Image<std::uint16_t> back = register_depth(depth, 0.001, c, c, shifted(0, 0.2));
  EXPECT_EQ(back(20, 15), 1200);
}

TEST(DepthRegistration, TheNearestWins) {
  Image<std::uint16_t> depth(40, 30);
  depth(20, 15) = 2000;  // moves by 2.5 + 2.5
  depth(15, 15) = 1000;  // moves by 10: both land near column 25
  const Camera c = camera(40, 30, 100);
  const Image<std::uint16_t> moved = register_depth(depth, 0.001, c, c, shifted(0.1));
  EXPECT_EQ(moved(25, 15), 1000);
}

TEST(DepthRegistration, AWallHasNoPinHolesInAFinerImage) {
  const Image<std::uint16_t> depth(40, 30, std::uint16_t{800});
  const Image<std::uint16_t> fine =
      register_depth(depth, 0.001, camera(40, 30, 50), camera(120, 90, 150), shifted(0.013, 0.001));
  for (int y = 5; y < 85; ++y) {
    for (int x = 5; x < 115; ++x) ASSERT_EQ(fine(x, y), 801) << x << " " << y;
  }
}

TEST(DepthRegistration, NothingShowsThroughASlantedSurface) {
  // Depth falls by 1 mm each 2 pixels, as codes do: beside a camera 6 cm away its pixels come apart
  // by a quarter of a pixel. A wall is behind.
  const Camera c = camera(320, 240, 390);
  Image<std::uint16_t> depth(320, 240, std::uint16_t{900});
  for (int y = 40; y < 200; ++y) {
    for (int x = 100; x < 220; ++x) depth(x, y) = static_cast<std::uint16_t>(300 + (x + y) / 2);
  }
  const Image<std::uint16_t> moved = register_depth(depth, 0.001, c, c, shifted(-0.06));
  for (int y = 60; y < 180; ++y) {
    int low = 320, high = -1, seen = 0;
    for (int x = 0; x < 320; ++x) {
      if (moved(x, y) == 0 || moved(x, y) > 600) continue;
      low = std::min(low, x);
      high = std::max(high, x);
      ++seen;
    }
    ASSERT_GT(seen, 100);
    ASSERT_EQ(high - low + 1, seen) << "the wall shows through row " << y;
  }
}

TEST(DepthRegistration, DistortionIsThatOfTheLens) {
  Image<std::uint16_t> depth(40, 30);
  depth(36, 26) = 1000;
  Camera lens = camera(160, 120, 200);
  lens.model = LensModel::opencv5;
  lens.distortion = {-0.2, 0.05, 0.001, -0.002, 0.01};
  const Image<std::uint16_t> seen =
      register_depth(depth, 0.001, camera(40, 30, 50), lens, shifted(0));
  const auto expected = project(lens, {(36 - 19.5) / 50, (26 - 14.5) / 50, 1});
  ASSERT_TRUE(expected);
  EXPECT_EQ(seen(static_cast<int>(std::lround(expected->x())),
                 static_cast<int>(std::lround(expected->y()))),
            1000);
}

TEST(DepthRegistration, WhatLiesBehindOrOutsideIsLeftOut) {
  const Image<std::uint16_t> depth(40, 30, std::uint16_t{100});
  const Camera c = camera(40, 30, 50);
  const Image<std::uint16_t> none(40, 30, std::uint16_t{0});
  EXPECT_EQ(register_depth(depth, 0.001, c, c, shifted(0, -0.2)), none);
  EXPECT_EQ(register_depth(depth, 0.001, c, c, shifted(9)), none);
}

TEST(DepthRegistration, RejectsWhatDoesNotFit) {
  const Camera c = camera(40, 30, 50);
  EXPECT_THROW(register_depth(Image<std::uint16_t>(39, 30), 0.001, c, c, {}),
               std::invalid_argument);
  EXPECT_THROW(register_depth(Image<std::uint16_t>(40, 30), 0, c, c, {}), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
