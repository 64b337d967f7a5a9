#include "benchmarks/suites/seedlings/exact_surface.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cousin {
namespace {

constexpr int kWidth = 40, kHeight = 30;

/// A view straight down from 1 m above (x, 0) on the plane z = 0, which is of one grey.
SampleView above(double x_m, float grey) {
  SampleView view;
  SplatViewLevel level;
  level.camera = {LensModel::pinhole, kWidth, kHeight, 40, 40, 19.5, 14.5};
  for (Image<float>& channel : level.color.channel) channel = Image<float>(kWidth, kHeight, grey);
  view.photograph.camera_from_world = look_at({x_m, 0, 1}, {x_m, 0, 0}, Eigen::Vector3d::UnitY());
  const Pose world_from_camera = inverse(view.photograph.camera_from_world);
  view.shown = Image<std::uint8_t>(kWidth, kHeight, 255);
  view.depth_m = Image<float>(kWidth, kHeight, 1.0F);
  view.position_m = Image<Eigen::Vector3f>(kWidth, kHeight);
  const Lens lens(level.camera);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const Eigen::Vector3d ray = *lens.unproject({x, y});
      view.position_m(x, y) = (world_from_camera * (ray / ray.z())).cast<float>();
    }
  }
  view.photograph.full = std::move(level);
  return view;
}

TEST(ExactSurface, ShowsTheMeanOfWhatTheViewsTrainedOnShow) {
  const SampleView a = above(0, 0.2F), b = above(0.1, 0.4F), c = above(-0.1, 0.6F);
  const SampleView held_out = above(0, 0.5F);
  const ExactSurface found = exact_surface({{&a, &b, &c}, {&held_out}, {}, {}});
  EXPECT_NEAR(found.psnr_db, 20, 1e-4);  // 0.4 beside 0.5
  // A tenth of a metre is four of the forty columns on either side.
  EXPECT_NEAR(static_cast<double>(found.pixels), (kWidth - 8) * kHeight, 2 * kHeight + 2 * kWidth);
}

TEST(ExactSurface, WhatHidesThePointDoesNotCount) {
  const SampleView a = above(0, 0.2F), b = above(0, 0.4F), c = above(0, 0.6F);
  SampleView leaf = above(0, 1.0F);
  leaf.depth_m = Image<float>(kWidth, kHeight, 0.5F);
  SampleView blank = above(0, 1.0F);
  blank.shown = Image<std::uint8_t>(kWidth, kHeight);
  const SampleView held_out = above(0, 0.5F);
  EXPECT_NEAR(exact_surface({{&a, &b, &c, &leaf, &blank}, {&held_out}, {}, {}}).psnr_db, 20, 1e-4);
}

// The same plane by cameras of other exposures: 0.2 to 0.6 of white are one light's.
TEST(ExactSurface, ExposuresAreTakenOut) {
  const SampleView a = above(0, 0.2F), b = above(0.1, 0.4F), c = above(-0.1, 0.6F);
  const SampleView held_out = above(0, 0.5F);
  const FieldViews views{{&a, &b, &c}, {&held_out}, {}, {}};
  EXPECT_GT(exact_surface_at_one_exposure(views).psnr_db, 60);
  EXPECT_EQ(exact_surface_at_one_exposure(views).pixels, exact_surface(views).pixels);
}

TEST(ExactSurface, TooFewViewsSayNothing) {
  const SampleView a = above(0, 0.2F), b = above(0, 0.4F), held_out = above(0, 0.5F);
  const ExactSurface found = exact_surface({{&a, &b}, {&held_out}, {}, {}});
  EXPECT_EQ(found.pixels, 0);
  EXPECT_TRUE(std::isnan(found.psnr_db));
}

}  // namespace
}  // namespace cousin
