#include "perception/splats/splat_render.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "perception/splats/splat_frame.h"
#include "sim/types/seams.h"
#include "tests/perception/splats/random_splats.h"

namespace cousin {
namespace {

SplatModel cube_model() {
  SplatModel model;
  model.splats = random_splats(400, 8);
  return model;
}

double largest_difference(const ColorPlanes& a, const ColorPlanes& b) {
  double largest = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < a.channel[k].size(); ++i) {
      const auto difference =
          static_cast<double>(std::abs(a.channel[k].data()[i] - b.channel[k].data()[i]));
      if (std::isnan(difference)) return kNaN;
      largest = std::max(largest, difference);
    }
  }
  return largest;
}

TEST(SplatRender, WhatIsTooMuchAtOnceIsDrawnInRowsAndIsTheSamePicture) {
  const SplatModel model = cube_model();
  const Camera camera = pinhole(150, 117, 130);  // rows that end inside a tile
  const Pose pose = view_of_cube();
  const SplatImage whole = render_splats(model, camera, pose);
  SplatRenderConfig few;
  few.most_pairs = 1500;
  SplatFrame frame;
  frame.most_pairs = few.most_pairs;
  EXPECT_THROW(draw_splats(best_splat_kernels(), to_planes(model.splats), model.sh_degree,
                           splat_camera(camera, pose, model.origin_in_world_m, 0.01), {},
                           SplatDepths::none, frame),
               TooManyPairs);
  const SplatImage in_rows = render_splats(model, camera, pose, few);
  // Rows count from where a part begins: pixels differ by rounding alone.
  EXPECT_LT(largest_difference(whole.color, in_rows.color), 1e-4);
  ASSERT_EQ(in_rows.depth_m.size(), whole.depth_m.size());
  ASSERT_EQ(in_rows.mean_depth_m.size(), whole.mean_depth_m.size());
  std::size_t others = 0;
  for (std::size_t i = 0; i < whole.alpha.size(); ++i) {
    EXPECT_NEAR(whole.alpha.data()[i], in_rows.alpha.data()[i], 1e-4);
    const float a = whole.depth_m.data()[i], b = in_rows.depth_m.data()[i];
    const float c = whole.mean_depth_m.data()[i], d = in_rows.mean_depth_m.data()[i];
    others += std::isnan(c) != std::isnan(d) || std::abs(c - d) > 1e-3F ? 1 : 0;
    others += std::isnan(a) != std::isnan(b) || std::abs(a - b) > 1e-3F ? 1 : 0;
  }
  EXPECT_LE(others, whole.alpha.size() / 500);  // at a threshold the next Gaussian is taken
  few.most_pairs = 3;
  try {
    (void)render_splats(model, camera, pose, few);
    FAIL() << "not even a row of tiles has so few";
  } catch (const TooManyPairs& error) {
    EXPECT_NE(std::string(error.what()).find("limit of 3"), std::string::npos) << error.what();
  }
}

/// Pixels whose colours differ by more than 1e-4: a decision at 1/255 that rounding turns may
/// change one by up to 4e-3.
int pixels_off(const ColorPlanes& a, const ColorPlanes& b) {
  int off = 0;
  for (std::size_t i = 0; i < a.channel[0].size(); ++i) {
    bool is_near = true;
    for (std::size_t k = 0; k < 3; ++k)
      is_near = is_near && std::abs(a.channel[k].data()[i] - b.channel[k].data()[i]) <= 1e-4F;
    off += is_near ? 0 : 1;
  }
  return off;
}

// Views rescaled with the scene see the same; only roundings at thresholds differ, in a handful of
// the 8100 pixels.
TEST(SplatRender, AnImageDoesNotDependOnTheSceneScale) {
  const Camera camera = pinhole(108, 75, 100);
  const ColorPlanes expected = render_splats(cube_model(), camera, view_of_cube()).color;
  for (const double factor : {1e-3, 0.37, 41.0, 1e3}) {
    SplatModel model = cube_model();
    for (Splat& s : model.splats) {
      s.centre_m *= static_cast<float>(factor);
      s.log_scale.array() += static_cast<float>(std::log(factor));
    }
    Pose pose = view_of_cube();
    pose.translation_m *= factor;
    const ColorPlanes image = render_splats(model, camera, pose).color;
    EXPECT_LT(largest_difference(image, expected), 0.01) << factor;
    EXPECT_LE(pixels_off(image, expected), 16) << factor;
  }
}

TEST(SplatRender, AnImageDoesNotDependOnWhereTheSceneIs) {
  const Camera camera = pinhole(108, 75, 100);
  const ColorPlanes expected = render_splats(cube_model(), camera, view_of_cube()).color;
  SplatModel model = cube_model();
  model.origin_in_world_m = {1e6, -2e6, 3e5};
  Pose pose = view_of_cube();
  pose.translation_m -= pose.rotation * model.origin_in_world_m;
  const ColorPlanes image = render_splats(model, camera, pose).color;
  // The pose's own translation has 1e6 m in a double: 2e-10 m.
  EXPECT_LT(largest_difference(image, expected), 0.01);
  EXPECT_LE(pixels_off(image, expected), 16);
}

TEST(SplatRender, DepthsOfOneDiscAreItsCentres) {
  SplatModel model;
  model.splats.resize(2);
  for (Splat& s : model.splats) {
    s.log_scale.setConstant(std::log(0.1F));
    s.opacity_logit = std::log(0.4F / 0.6F);
  }
  model.splats[0].centre_m = {0, 0, 1};
  model.splats[1].centre_m = {0, 0, 2};
  Camera camera = pinhole(64, 64, 60);
  camera.cx_px = camera.cy_px = 32;
  const SplatImage image = render_splats(model, camera, Pose{});
  // 0.6 is left behind the first, 0.36 behind the second.
  EXPECT_FLOAT_EQ(image.depth_m(32, 32), 2);
  EXPECT_NEAR(image.mean_depth_m(32, 32), (0.4 * 1 + 0.24 * 2) / 0.64, 1e-5);
  EXPECT_NEAR(image.alpha(32, 32), 0.64, 1e-5);
  EXPECT_TRUE(std::isnan(image.depth_m(0, 0)));
  EXPECT_TRUE(std::isnan(image.mean_depth_m(0, 0)));
  EXPECT_EQ(image.alpha(0, 0), 0);
}

TEST(SplatRender, FlatGaussiansOfASlantedPlaneHaveThePlanesDepth) {
  // Discs of 0.05 in the plane z = 1 + 0.8 x: their centres' depths alone are up to 0.1 off.
  const double slant = std::atan(0.8);
  SplatModel model;
  model.sh_degree = 0;
  for (int column = -12; column <= 12; ++column) {
    for (int row = -12; row <= 12; ++row) {
      Splat s;
      const float x = 0.05F * static_cast<float>(column);
      s.centre_m = {x, 0.05F * static_cast<float>(row), 1 + 0.8F * x};
      s.log_scale = {std::log(0.05F), std::log(0.05F), std::log(1e-4F)};
      s.rotation_wxyz = {static_cast<float>(std::cos(-slant / 2)), 0,
                         static_cast<float>(std::sin(-slant / 2)), 0};
      s.opacity_logit = 2;
      model.splats.push_back(s);
    }
  }
  Camera camera = pinhole(64, 64, 80);
  camera.cx_px = camera.cy_px = 31.5;
  const SplatImage image = render_splats(model, camera, Pose{});
  for (int y = 16; y < 48; y += 3) {
    for (int x = 16; x < 48; x += 3) {
      const double u = (x - camera.cx_px) / camera.fx_px;
      const double plane_m = 1 / (1 - 0.8 * u);
      EXPECT_NEAR(image.depth_m(x, y), plane_m, 0.01 * plane_m) << x << " " << y;
      EXPECT_NEAR(image.mean_depth_m(x, y), plane_m, 0.01 * plane_m) << x << " " << y;
    }
  }
}

TEST(SplatRender, OneLargeDiscHasItsPlanesDepthToFourTimesItsOwn) {
  // 79 degrees aslant: linear in the image its depth would be below 0 from x = -20 px on.
  const double slant = 79 * std::numbers::pi / 180, slope = std::tan(slant);
  SplatModel model;
  model.sh_degree = 0;
  Splat s;
  s.centre_m = {0, 0, 1};
  s.log_scale = {std::log(10.0F), std::log(10.0F), std::log(1e-4F)};
  s.rotation_wxyz = {static_cast<float>(std::cos(-slant / 2)), 0,
                     static_cast<float>(std::sin(-slant / 2)), 0};
  s.opacity_logit = 6;
  model.splats.push_back(s);
  Camera camera = pinhole(64, 16, 100);
  camera.cx_px = 31.5;
  camera.cy_px = 7.5;
  const SplatImage image = render_splats(model, camera, Pose{});
  int compared = 0;
  for (int x = 0; x < 64; ++x) {
    if (!std::isfinite(image.depth_m(x, 8))) continue;
    EXPECT_GT(image.depth_m(x, 8), 0) << x;
    EXPECT_LT(image.depth_m(x, 8), 4.001) << x;
    const double nearness = 1 - slope * (x - camera.cx_px) / camera.fx_px;
    if (nearness < 0.26) continue;
    EXPECT_NEAR(image.depth_m(x, 8), 1 / nearness, 0.002 / nearness) << x;
    ++compared;
  }
  EXPECT_GT(compared, 40);
}

/// Discs of 0.12 mm on a ball of 1.5 mm about the origin, as many as cover each place five times.
SplatModel covered_ball() {
  constexpr int kDiscs = 2000;
  SplatModel model;
  model.sh_degree = 0;
  for (int i = 0; i < kDiscs; ++i) {  // even in z, turned by the golden angle
    const double z = -1 + (2 * i + 1.0) / kDiscs, around = 2.39996322972865 * i;
    const double r = std::sqrt(1 - z * z);
    const Eigen::Vector3d normal(r * std::cos(around), r * std::sin(around), z);
    const auto q = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), normal);
    Splat s;
    s.centre_m = (0.0015 * normal).cast<float>();
    s.log_scale = {std::log(1.2e-4F), std::log(1.2e-4F), std::log(6e-6F)};
    s.rotation_wxyz = {static_cast<float>(q.w()), static_cast<float>(q.x()),
                       static_cast<float>(q.y()), static_cast<float>(q.z())};
    s.opacity_logit = 2.5;
    model.splats.push_back(s);
  }
  return model;
}

/// Mean of how far the depths of a ball 12 pixels wide lie outside of it, in metres.
double mean_outside_m(double low_pass_px2) {
  Camera camera = pinhole(24, 24, 1200);
  camera.cx_px = camera.cy_px = 11.5;
  Pose pose;
  pose.translation_m = {0, 0, 0.3};
  const SplatImage image =
      render_splats(covered_ball(), camera, pose, {.low_pass_px2 = low_pass_px2});
  double sum_m = 0;
  int count = 0;
  for (int y = 0; y < 24; ++y) {
    for (int x = 0; x < 24; ++x) {
      const double depth_m = static_cast<double>(image.depth_m(x, y));
      if (!std::isfinite(depth_m)) continue;
      const Eigen::Vector3d at_m(depth_m * (x - 11.5) / 1200, depth_m * (y - 11.5) / 1200,
                                 depth_m - 0.3);
      sum_m += at_m.norm() - 0.0015;
      ++count;
    }
  }
  EXPECT_GT(count, 90);  // of the 113 that the ball covers
  return sum_m / std::max(1, count);
}

// A pixel is 0.25 mm there. Where a disc's tangent plane is met two of its 0.19 mm (0.12, and 0.3
// of a pixel's square) from its centre it stands 0.05 mm over the ball, and more over the edge.
TEST(SplatRender, ANarrowLowPassKeepsDepthsOnASmallCurvedSurface) {
  EXPECT_GT(mean_outside_m(0.3), 8e-5);
  EXPECT_LT(std::abs(mean_outside_m(0.03)), 3e-5);
}

TEST(SplatRender, AModelIsDrawnWithItsOwnLowPassUnlessAnotherIsGiven) {
  SplatModel model = cube_model();
  const auto drawn = [&](double asked_px2) {
    return render_splats(model, pinhole(32, 24, 30), view_of_cube(), {.low_pass_px2 = asked_px2})
        .color.channel[1];
  };
  const auto same = [](const Image<float>& a, const Image<float>& b) {
    return std::equal(a.begin(), a.end(), b.begin());
  };
  const Image<float> wide = drawn(0);
  EXPECT_TRUE(same(wide, drawn(0.3)));
  model.low_pass_px2 = 0.05;
  EXPECT_FALSE(same(wide, drawn(0)));
  EXPECT_TRUE(same(drawn(0), drawn(0.05)));
  EXPECT_TRUE(same(wide, drawn(0.3)));
}

TEST(SplatRender, ALowPassIsAboveZero) {
  SplatModel model = cube_model();
  model.low_pass_px2 = 0;
  EXPECT_THROW(render_splats(model, pinhole(8, 8, 9), Pose{}), std::invalid_argument);
  for (const double low_pass_px2 : {-0.3, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(
        render_splats(cube_model(), pinhole(8, 8, 9), Pose{}, {.low_pass_px2 = low_pass_px2}),
        std::invalid_argument);
  }
}

TEST(SplatRender, AnEmptyModelIsItsBackground) {
  SplatRenderConfig config;
  config.background = {0.1F, 0.2F, 0.3F};
  const SplatImage image = render_splats({}, pinhole(17, 9, 10), Pose{}, config);
  EXPECT_EQ(image.color.channel[2](16, 8), 0.3F);
  EXPECT_EQ(image.alpha(3, 3), 0);
}

TEST(SplatRender, OtherLensesAreRefused) {
  Camera camera = pinhole(32, 32, 30);
  camera.model = LensModel::opencv5;
  EXPECT_THROW(render_splats(cube_model(), camera, Pose{}), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
