#include "benchmarks/suites/seedlings/sample_capture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sim/sensors/phone.h"

namespace cousin {
namespace {

SeedlingsSample small_sample() {
  SeedlingsSample sample;
  sample.views = 3;
  sample.width_px = 80;
  sample.height_px = 60;
  sample.pixel_samples = 2;
  return sample;
}

TEST(SampleCapture, APixelThatAveragesMoreHasADeeperWell) {
  const PhoneConfig preset = phone_preset("phone_video_720p");
  const PhoneConfig half = with_picture(preset, preset.width_px / 2, 300);
  EXPECT_EQ(half.width_px, 640);
  EXPECT_EQ(half.height_px, 300);
  EXPECT_DOUBLE_EQ(half.full_well_e, 4 * preset.full_well_e);
  EXPECT_DOUBLE_EQ(half.read_noise_e, 2 * preset.read_noise_e);
  EXPECT_DOUBLE_EQ(half.prnu, preset.prnu / 2);
  EXPECT_EQ(half.bits, preset.bits + 1);
  EXPECT_DOUBLE_EQ(half.focal_px_per_width, preset.focal_px_per_width);
  const PhoneConfig same = with_picture(preset, preset.width_px, preset.height_px);
  EXPECT_DOUBLE_EQ(same.full_well_e, preset.full_well_e);
  EXPECT_EQ(same.bits, preset.bits);
}

TEST(SampleCapture, TruthAndPhotographAreOfTheSamePinholeCamera) {
  const SampleCapture capture = photograph_sample(small_sample(), SamplePlan::whole_tray, 1, 4);
  ASSERT_EQ(capture.views.size(), 4u);  // one of them held out
  EXPECT_EQ(capture.noise_views, 1);
  EXPECT_GT(capture.noise_psnr_db, 15);
  EXPECT_LT(capture.noise_psnr_db, 60);
  int seedling_pixels = 0, greener = 0;
  for (const SampleView& view : capture.views) {
    const SplatViewLevel& level = view.photograph.full;
    EXPECT_EQ(level.camera.model, LensModel::pinhole);
    const Lens lens(level.camera);
    ASSERT_EQ(view.depth_m.width(), level.camera.width_px);
    for (int y = 0; y < view.depth_m.height(); y += 7) {
      for (int x = 0; x < view.depth_m.width(); x += 7) {
        const Eigen::Vector3d point_m = view.position_m(x, y).cast<double>();
        if (!point_m.allFinite()) continue;
        const Eigen::Vector3d in_camera_m = view.photograph.camera_from_world.rotation * point_m +
                                            view.photograph.camera_from_world.translation_m;
        const auto pixel = lens.project(in_camera_m);
        ASSERT_TRUE(pixel);
        // Positions are floats: 1e-7 of a metre in 0.2 m times 70 px.
        EXPECT_NEAR((*pixel - Eigen::Vector2d(x, y)).norm(), 0, 1e-3);
        EXPECT_NEAR(in_camera_m.z(), view.depth_m(x, y), 1e-5);
      }
    }
    // Plants are where the photograph is green.
    for (std::size_t i = 0; i < view.seedlings.size(); ++i) {
      if (view.seedlings.data()[i] == 0) continue;
      EXPECT_EQ(view.shown.data()[i], 255);
      ++seedling_pixels;
      greener += level.color.channel[1].data()[i] > level.color.channel[0].data()[i];
    }
  }
  EXPECT_GT(seedling_pixels, 50);
  EXPECT_GT(greener, 0.8 * seedling_pixels);
}

TEST(SampleCapture, ViewsOfOneSideAreOfTheSameTrayFromFewerSides) {
  SeedlingsSample sample = small_sample();
  sample.views = 8;
  const SampleCapture whole = photograph_sample(sample, SamplePlan::whole_tray, 0, 4);
  const SampleCapture side = photograph_sample(sample, SamplePlan::one_side, 0, 4);
  EXPECT_EQ(side.views.size(), 8u);
  EXPECT_EQ(side.noise_views, 0);
  // |mean of the horizontal directions towards the camera|: none all around, near one on one side.
  const auto bias = [](const SampleCapture& capture) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    double weight = 0;
    for (const SampleView& view : capture.views) {
      const Eigen::Vector3d axis =
          view.photograph.camera_from_world.rotation.inverse() * Eigen::Vector3d::UnitZ();
      sum -= axis.head<2>();
      weight += axis.head<2>().norm();
    }
    return sum.norm() / weight;
  };
  EXPECT_LT(bias(whole), 0.4);
  EXPECT_GT(bias(side), 0.6);
}

TEST(SampleCapture, GaussiansStartWhereTheTrayIsAndOnTheBench) {
  const std::vector<StartPoint> points = sample_start(small_sample(), 600, Rng(1));
  ASSERT_EQ(points.size(), 600u);
  int beside = 0;
  for (const StartPoint& point : points) {
    const bool is_on_tray =
        std::abs(point.position_m.x()) <= 0.35 && std::abs(point.position_m.y()) <= 0.175;
    beside += !is_on_tray;
    EXPECT_LE(point.position_m.z(), is_on_tray ? 0.1 : -0.03);
    EXPECT_GE(point.position_m.z(), -0.04);
  }
  EXPECT_LT(beside, 200);
  EXPECT_GT(beside, 120);
}

TEST(SampleCapture, BesideSurfacesTheBenchIsOpaqueAndTheAirThin) {
  const std::vector<StartPoint> points = unswept_start(small_sample(), 600, Rng(1));
  ASSERT_EQ(points.size(), 560u);
  int on_bench = 0;
  for (const StartPoint& point : points) {
    const bool is_bench = point.opacity > 0.5;
    on_bench += is_bench;
    if (is_bench) {
      EXPECT_LE(point.position_m.z(), -0.03);
    } else {
      EXPECT_LT(point.opacity, 0.05);
      EXPECT_GT(point.opacity, 0);
      EXPECT_LE(std::abs(point.position_m.x()), 0.35);
      EXPECT_LE(std::abs(point.position_m.y()), 0.175);
    }
  }
  EXPECT_EQ(on_bench, 200);
}

}  // namespace
}  // namespace cousin
