#include "benchmarks/suites/seedlings/surface_coverage.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace cousin {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

Camera camera_64() {
  Camera camera;
  camera.width_px = 64;
  camera.height_px = 48;
  camera.fx_px = camera.fy_px = 60;
  camera.cx_px = 31.5;
  camera.cy_px = 23.5;
  return camera;
}

/// Looks down at the plane z = 0 from 1 m above (x, 0).
Pose above(double x_m) { return look_at({x_m, 0, 1}, {x_m, 0, 0}, Eigen::Vector3d::UnitY()); }

Image<float> plane_m() { return Image<float>(64, 48, 1.0F); }

Image<Eigen::Vector3f> points(std::vector<Eigen::Vector3f> of) {
  Image<Eigen::Vector3f> image(static_cast<int>(of.size()), 1);
  std::copy(of.begin(), of.end(), image.begin());
  return image;
}

TEST(SurfaceCoverage, AViewSeesWhatIsInItsImageAndNotBehindASurface) {
  const Image<float> open = plane_m();
  Image<float> covered = plane_m();
  for (float& z : covered) z = 0.5F;  // a leaf half way up, all over
  const std::vector<DepthSight> views = {{camera_64(), above(0), &open},
                                         {camera_64(), above(0.4), &open},
                                         {camera_64(), above(0), &covered}};
  // Half a picture is 32 / 60 = 0.533 m wide at 1 m.
  const Image<std::uint16_t> seen = views_that_see(
      points({{0, 0, 0},      // by the first two; the leaf hides it
              {-0.5F, 0, 0},  // outside the second's
              {0.9F, 0, 0},   // outside the first's
              {0, 0, 0.5F},   // on the leaf: outside the second's, which is half as wide there
              {2, 0, 0},      // by none
              {0, 0, 2},      // behind the cameras
              {kNone, kNone, kNone}}),
      views);
  const int expected[] = {2, 1, 1, 2, 0, 0, 0};
  for (int i = 0; i < 7; ++i) EXPECT_EQ(seen(i, 0), expected[i]) << i;
}

TEST(SurfaceCoverage, NothingBehindAPixelWithoutSurfaceIsHidden) {
  const Image<float> none(64, 48, kNone);
  const std::vector<DepthSight> views = {{camera_64(), above(0), &none}};
  EXPECT_EQ(views_that_see(points({{0, 0, 0}}), views)(0, 0), 1);
  // Beside a surface 0.5 m before the point there is none: as beside an edge.
  Image<float> edge(64, 48, kNone);
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 32; ++x) edge(x, y) = 0.5F;
  }
  const std::vector<DepthSight> half = {{camera_64(), above(0), &edge}};
  EXPECT_EQ(views_that_see(points({{-0.5F / 60, 0, 0}, {-4.5F / 60, 0, 0}}), half)(0, 0), 1);
  EXPECT_EQ(views_that_see(points({{-0.5F / 60, 0, 0}, {-4.5F / 60, 0, 0}}), half)(1, 0), 0);
}

TEST(SurfaceCoverage, WhatThePhotographDoesNotShowIsNotSeen) {
  const Image<float> open = plane_m();
  Image<std::uint8_t> shown(64, 48, 255);
  shown(32, 24) = 0;
  const std::vector<DepthSight> views = {{camera_64(), above(0), &open, &shown}};
  const auto at = [&](double x_px) {
    const Camera camera = camera_64();
    return Eigen::Vector3f(static_cast<float>((x_px - camera.cx_px) / camera.fx_px),
                           static_cast<float>((camera.cy_px - 24) / camera.fy_px), 0);
  };
  const Image<std::uint16_t> seen = views_that_see(points({at(32), at(34)}), views);
  EXPECT_EQ(seen(0, 0), 0);
  EXPECT_EQ(seen(1, 0), 1);
  shown = Image<std::uint8_t>(10, 10, 255);
  EXPECT_THROW(views_that_see(points({at(32)}), views), std::invalid_argument);
}

// Depth is known at pixel centres: a point beside an edge is seen where a neighbour is as deep.
TEST(SurfaceCoverage, APointBesideAnEdgeIsSeen) {
  Image<float> edge = plane_m();
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 32; ++x) edge(x, y) = 0.5F;
  }
  const std::vector<DepthSight> views = {{camera_64(), above(0), &edge}};
  const auto at_pixel = [](double x) {
    return Eigen::Vector3f(static_cast<float>((x - 31.5) / 60), 0, 0);
  };
  const Image<std::uint16_t> seen =
      views_that_see(points({at_pixel(31), at_pixel(30), at_pixel(20), at_pixel(40)}), views);
  EXPECT_EQ(seen(0, 0), 1);
  EXPECT_EQ(seen(1, 0), 0);
  EXPECT_EQ(seen(2, 0), 0);
  EXPECT_EQ(seen(3, 0), 1);
}

TEST(SurfaceCoverage, ADepthImageOfAnotherSizeIsRefused) {
  const Image<float> small(32, 48, 1.0F);
  const std::vector<DepthSight> views = {{camera_64(), above(0), &small}};
  EXPECT_THROW(views_that_see(points({{0, 0, 0}}), views), std::invalid_argument);
}

TEST(SurfaceCoverage, SharesAreOfThePointsThatCount) {
  Image<std::uint16_t> seen(4, 1);
  seen(1, 0) = 1;
  seen(2, 0) = 3;
  seen(3, 0) = 7;
  CoverageShare share;
  EXPECT_TRUE(std::isnan(share.seen_by(1)));
  share.add(seen);
  EXPECT_EQ(share.points(), 4);
  EXPECT_DOUBLE_EQ(share.seen_by(0), 1);
  EXPECT_DOUBLE_EQ(share.seen_by(1), 0.75);
  EXPECT_DOUBLE_EQ(share.seen_by(3), 0.5);
  EXPECT_DOUBLE_EQ(share.seen_by(8), 0);
  Image<std::uint8_t> mask(4, 1);
  mask(0, 0) = mask(3, 0) = 255;
  CoverageShare masked;
  masked.add(seen, mask);
  EXPECT_EQ(masked.points(), 2);
  EXPECT_DOUBLE_EQ(masked.seen_by(3), 0.5);
}

}  // namespace
}  // namespace cousin
