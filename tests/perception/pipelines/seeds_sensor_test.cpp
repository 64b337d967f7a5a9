#include "perception/pipelines/seeds_sensor.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/types/rng.h"

namespace cousin {
namespace {

/// A capture of the marked board, posed at 0.4 m by f = 400 px: a pixel spans 1 mm.
struct Seen {
  Capture capture;
  Estimate estimate;
};
Seen board_with_noise(double sigma_m) {
  Seen seen;
  seen.capture.board = "markers";
  FramePose& pose = seen.estimate.poses.emplace_back();
  pose.status = PoseStatus::ok;
  pose.camera.fx_px = pose.camera.fy_px = 400;
  pose.camera_from_world.translation_m = Eigen::Vector3d(0, 0, 0.4);
  Rng rng(3);
  for (int i = 0; i < 20000; ++i) {
    CloudPoint point;
    point.position_m =
        Eigen::Vector3d(uniform(rng, -0.05, 0.05), uniform(rng, -0.05, 0.05), sigma_m * normal(rng))
            .cast<float>();
    seen.estimate.cloud.push_back(point);
  }
  return seen;
}

SeedsPipelineConfig with_method(SeedsMethod method) {
  SeedsPipelineConfig config;
  config.method = method;
  return config;
}

TEST(SeedsSensor, TheCloudsNoiseOnTheBoardSaysWhatIsAnObject) {
  const Seen seen = board_with_noise(0.001);
  const auto config = with_method(SeedsMethod::sensor_depth);
  const BoardClusterConfig clusters = clusters_for(config, seen.capture, seen.estimate);
  // The mode of 11 000 heights is known to a tenth of a sigma, the spread about it as well.
  EXPECT_NEAR(clusters.min_height_m, 0.002, 0.0004);
  EXPECT_NEAR(clusters.min_top_m, 0.003, 0.0006);
  const auto quiet = board_with_noise(1e-5);
  EXPECT_EQ(clusters_for(config, quiet.capture, quiet.estimate).min_height_m,
            config.clusters.min_height_m);
}

TEST(SeedsSensor, PointsWithinAWindowOfTheRimAreLeftOutAndTheRestErrsAsTheBoardDoes) {
  const Seen seen = board_with_noise(0.001);
  SeedsPipelineConfig config = with_method(SeedsMethod::sensor_depth);
  const SurfaceFitConfig surface = surface_for(config, seen.capture, seen.estimate);
  EXPECT_NEAR(surface.cloud_rim_m, 5.5e-3, 1e-9);  // half of 11 px of 1 mm
  // Patches of 11 mm hold 240 points: their means err by 0.065 mm, and the mode is off by up to
  // 0.2 mm.
  EXPECT_GT(surface.cloud_sigma_m, 0.03e-3);
  EXPECT_LT(surface.cloud_sigma_m, 0.3e-3);
  EXPECT_EQ(surface.cloud_bias_sigma_m, surface.cloud_sigma_m);
  EXPECT_EQ(surface.outline_bias_sigma_px, config.sensor_outline_sigma_px);
  // 31.4 mm around a seed are 31 pixels: 10 waves of 3.
  EXPECT_EQ(surface.degree, 10);
  Seen near = seen;
  near.estimate.poses[0].camera.fx_px = 2000;
  EXPECT_EQ(surface_for(config, near.capture, near.estimate).degree, config.surface.degree);
  config.sensor_depth.window_px = 0;
  EXPECT_EQ(surface_for(config, seen.capture, seen.estimate).cloud_rim_m,
            config.surface.cloud_rim_m);
}

TEST(SeedsSensor, SigmasOfSizesAreAddedInPixels) {
  const SeedsPipelineConfig config = with_method(SeedsMethod::sensor_depth);
  const MeshTraitConfig traits = traits_for(config, 0.0002);
  EXPECT_NEAR(traits.height_sigma_px, std::hypot(config.traits.height_sigma_px, 1.0), 1e-12);
  EXPECT_NEAR(traits.length_sigma_px, std::hypot(config.traits.length_sigma_px, 0.25), 1e-12);
  EXPECT_EQ(traits_for(config, kNaN).height_sigma_px, config.traits.height_sigma_px);
}

TEST(SeedsSensor, SizesOfPointsAreKnownToTheMatchingWindow) {
  const Seen seen = board_with_noise(0.001);
  const SeedsPipelineConfig config = with_method(SeedsMethod::depth_only);
  SpecimenTraits specimen;
  specimen.status = TraitStatus::ok;
  for (const char* name : {"length", "width", "height", "area", "volume"})
    specimen.traits.push_back({name, "", 0.022, kNaN});
  const Traits known = with_point_sigmas({specimen}, config, seen.capture, seen.estimate);
  EXPECT_NEAR(known[0].traits[0].sigma, 1.5 * 0.011, 1e-9);  // 11 px of 1 mm
  EXPECT_NEAR(known[0].traits[2].sigma, 0.004, 0.0008);
  EXPECT_NEAR(known[0].traits[3].sigma, 1.5 * 0.022, 1e-6);  // three quarters and three quarters
  EXPECT_NEAR(known[0].traits[4].sigma, std::pow(0.022, 3), 1e-12);
  Estimate unposed = seen.estimate;
  unposed.poses.clear();
  EXPECT_TRUE(
      std::isnan(with_point_sigmas({specimen}, config, seen.capture, unposed)[0].traits[0].sigma));
}

TEST(SeedsSensor, WhatIsNoHigherThanTheNoiseIsNotSolved) {
  const Seen seen = board_with_noise(0.001);
  Traits traits(3);
  const double heights_m[] = {0.002, 0.006, 0.006}, sigmas_m[] = {0.0001, 0.0001, 0.0025};
  for (std::size_t i = 0; i < 3; ++i) {
    traits[i].status = TraitStatus::ok;
    traits[i].traits = {{"height", "m", heights_m[i], sigmas_m[i]}};
  }
  const auto sensor = with_method(SeedsMethod::sensor_depth);
  const Traits kept = without_noise(traits, sensor, seen.capture, seen.estimate);
  EXPECT_EQ(kept[0].status, TraitStatus::not_solved);  // below 3 mm, 3 sigmas of the cloud
  EXPECT_TRUE(kept[0].traits.empty());
  EXPECT_NE(kept[0].reason.find("within the noise"), std::string::npos);
  EXPECT_EQ(kept[1].status, TraitStatus::ok);
  EXPECT_EQ(kept[2].status, TraitStatus::not_solved);  // below 3 of its own
  const auto ours = with_method(SeedsMethod::ours);
  EXPECT_EQ(without_noise(traits, ours, seen.capture, seen.estimate)[0].status, TraitStatus::ok);
}

TEST(SeedsSensor, OtherMethodsAreAsTheyWere) {
  const Seen seen = board_with_noise(0.001);
  for (const SeedsMethod method : {SeedsMethod::ours, SeedsMethod::paper}) {
    SeedsPipelineConfig config = with_method(method);
    BoardClusterConfig clusters = clusters_for(config, seen.capture, seen.estimate);
    SurfaceFitConfig surface = surface_for(config, seen.capture, seen.estimate);
    MeshTraitConfig traits = traits_for(config, 0.0002);
    EXPECT_EQ(to_toml(fields(clusters)), to_toml(fields(config.clusters)));
    EXPECT_EQ(to_toml(fields(surface)), to_toml(fields(config.surface)));
    EXPECT_EQ(to_toml(fields(traits)), to_toml(fields(config.traits)));
  }
}

}  // namespace
}  // namespace cousin
