#include "benchmarks/loop/perceive_views.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "perception/splats/splat_ply.h"
#include "sim/dataset/atomic_file.h"
#include "sim/dataset/seam_io.h"
#include "sim/imaging/image_io.h"
#include "sim/process/scratch_folder.h"
#include "tests/benchmarks/loop/row_value.h"
#include "tests/perception/pipelines/cube_capture.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

ViewsPipelineConfig quick() {
  ViewsPipelineConfig config;
  config.steps = 400;
  config.most_splats = 1500;
  config.start_points = 600;
  config.mesh_cells = 40;
  config.hold_out_every = 4;
  return config;
}

TEST(PerceiveViews, WritesSeamsScoresAndPictures) {
  const ScratchFolder scratch("cousin-views");
  const fs::path out = scratch.path() / "est";
  const ViewsRun run = perceive_views(cube_capture(), quick(), 1, {}, 0, "cube", out);
  EXPECT_EQ(read_poses(out).size(), 12U);
  EXPECT_EQ(read_splat_ply(out / "splats.ply").model.splats.size(),
            run.estimate.splats.splats.size());
  EXPECT_EQ(read_depths(out).size(), 12U);
  EXPECT_EQ(read_cloud(out).size(), run.estimate.cloud.size());
  EXPECT_TRUE(fs::exists(out / "meshes" / "000000.ply"));
  EXPECT_FALSE(fs::exists(out / "splats.unfinished"));
  for (const char* id : {"000000", "000004", "000008"}) {  // those held out
    const Image<Rgb8> both = read_color(out / "pictures" / (std::string(id) + ".png"));
    EXPECT_EQ(both.width(), 2 * 108);
    EXPECT_EQ(both.height(), 75);
  }
  const std::string seen = read_file(out / "splats_seen.csv");
  EXPECT_EQ(static_cast<std::size_t>(std::count(seen.begin(), seen.end(), '\n')),
            run.estimate.splats.splats.size() + 1);
  EXPECT_THAT(read_file(out / "scores.csv"), testing::HasSubstr("held_out.psnr"));
  EXPECT_GT(value_of(run.rows, "train.psnr"), 22);
  EXPECT_GT(value_of(run.rows, "held_out.psnr"), 12.5);
  EXPECT_LT(value_of(run.rows, "held_out.psnr"), value_of(run.rows, "train.psnr"));
  EXPECT_GT(value_of(run.rows, "train.psnr_exposed"), value_of(run.rows, "train.psnr"));
  EXPECT_GT(value_of(run.rows, "held_out.psnr_exposed"), value_of(run.rows, "held_out.psnr"));
  EXPECT_GT(value_of(run.rows, "gaussians.seen_by_3"), 0.2);
  EXPECT_GT(value_of(run.rows, "mesh.area"), 1);
}

TEST(PerceiveViews, ANetworkScoresImagesToo) {
  struct Brightness : LearnedDistance {  // difference of two sums
    double between(const FidelityPlanes& image, const FidelityPlanes& photograph) const override {
      double sum = 0;
      for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t i = 0; i < image[c].size(); ++i)
          sum += static_cast<double>(image[c].data()[i] - photograph[c].data()[i]);
      }
      return std::abs(sum);
    }
  } network;
  const ViewsRun run =
      perceive_views(cube_capture(), quick(), 1, {}, 0, "cube", {}, {}, {}, &network);
  EXPECT_GT(value_of(run.rows, "train.lpips"), 0);
  EXPECT_GT(value_of(run.rows, "held_out.lpips"), 0);
}

TEST(PerceiveViews, AForeignModelIsScoredLikeOurs) {
  const ScratchFolder scratch("cousin-views");
  SplatModel truth = cube_of_splats();
  truth.low_pass_px2 = 0.3;
  fs::create_directories(scratch.path() / "mine");
  write_splat_ply(scratch.path() / "mine" / "splats.ply", truth);
  const StageSource mine = parse_stage_source("splats=dir:" + (scratch.path() / "mine").string());
  const ViewsRun run = perceive_views(cube_capture(), quick(), 1, {mine}, 0, "cube", {});
  // The photographs are of this very model, rounded to codes.
  EXPECT_GT(value_of(run.rows, "train.psnr"), 50);
  EXPECT_GT(value_of(run.rows, "held_out.psnr"), 50);
  EXPECT_EQ(value_of(run.rows, "gaussians"), static_cast<double>(truth.splats.size()));
}

TEST(PerceiveViews, SomebodysDepthMayBeNone) {
  const ScratchFolder scratch("cousin-views");
  write_depths(scratch.path(), {});
  const StageSource none = parse_stage_source("depth=dir:" + scratch.path().string());
  ViewsPipelineConfig config = quick();
  config.steps = 20;
  const ViewsRun run = perceive_views(cube_capture(), config, 1, {none}, 0, "cube", {});
  EXPECT_TRUE(run.estimate.cloud.empty());
  EXPECT_GT(value_of(run.rows, "train.psnr"), 0);
  EXPECT_GT(value_of(run.rows, "gaussians"), 0);
}

TEST(PerceiveViews, SomebodysPosesHaveCamerasOfTheFullSize) {
  const ScratchFolder scratch("cousin-views");
  const Capture capture = cube_capture();
  write_poses(scratch.path(), reported_poses(capture));
  const StageSource mine = parse_stage_source("poses=dir:" + scratch.path().string());
  ViewsPipelineConfig config = quick();
  config.steps = 20;
  config.largest_side_px = 40;
  const ViewsRun run = perceive_views(capture, config, 1, {mine}, 0, "cube", {});
  EXPECT_EQ(run.estimate.poses.at(0).camera.width_px, 36);
  EXPECT_EQ(run.estimate.depths.at(0).depth_m.width(), 36);
}

TEST(PerceiveViews, WhatMasksLeaveOutIsNeitherTrainedOnNorScored) {
  const ScratchFolder scratch("cousin-views");
  const fs::path masks = scratch.path() / "masks";
  Capture capture = cube_capture();
  ViewsPipelineConfig config = quick();
  config.steps = 60;
  config.one_exposure = false;
  config.swept_points = 0;
  config.masks = masks.string();
  const auto run = [&] { return perceive_views(capture, config, 1, {}, 0, "cube", {}); };
  fs::create_directories(masks);
  EXPECT_THAT(run, testing::ThrowsMessage<std::runtime_error>(
                       testing::HasSubstr("holds no mask of any frame (\"000000.png\")")));
  // The left half of each photograph is somebody's hand, in another colour in the second capture.
  Image<std::uint8_t> right(108, 75, 0);
  for (int y = 0; y < 75; ++y) {
    for (int x = 54; x < 108; ++x) right(x, y) = 1;
  }
  for (const Frame& frame : capture.frames) {
    char name[16];
    std::snprintf(name, sizeof name, "%06d.png", frame.id);
    write_png(masks / name, right);
  }
  const ViewsRun first = run();
  for (Frame& frame : capture.frames) {
    for (int y = 0; y < 75; ++y) {
      for (int x = 0; x < 54; ++x) frame.sensors[0].color(x, y) = {255, 0, 255};
    }
  }
  const ViewsRun second = run();
  ASSERT_FALSE(first.estimate.splats.splats.empty());
  EXPECT_EQ(value_of(first.rows, "gaussians"), value_of(second.rows, "gaussians"));
  for (const char* metric : {"train.psnr", "held_out.psnr", "held_out.ssim"})
    EXPECT_EQ(value_of(first.rows, metric), value_of(second.rows, metric)) << metric;
  write_png(masks / "000003.png", Image<std::uint8_t>(50, 75, 255));
  EXPECT_THAT(run, testing::ThrowsMessage<std::runtime_error>(testing::AllOf(
                       testing::HasSubstr("000003.png"),
                       testing::HasSubstr("50 x 75 pixels for a photograph of 108 x 75"))));
}

TEST(PerceiveViews, AMaskOfTheFullSizeIsMadeSmallWithItsPhotograph) {
  Image<std::uint8_t> mask(109, 75, 200);
  mask(5, 4) = 0;
  mask(108, 2) = 0;  // of a column that fills no pixel
  const Image<std::uint8_t> small = reduced_mask(mask, 54, 37);
  EXPECT_EQ(small(2, 2), 0);
  EXPECT_EQ(std::count(small.begin(), small.end(), 255), 54 * 37 - 1);
  EXPECT_THROW((void)reduced_mask(mask, 55, 37), std::invalid_argument);
  EXPECT_THROW((void)reduced_mask(mask, 200, 150), std::invalid_argument);
}

TEST(PerceiveViews, TheUnitOfSomebodysPosesIsNotKnown) {
  const ScratchFolder scratch("cousin-views");
  const Capture capture = cube_capture();
  write_poses(scratch.path(), reported_poses(capture));
  const auto unit_of_area = [&](const std::vector<StageSource>& sources, std::string* warnings) {
    const ViewsRun run = perceive_views(capture, quick(), 1, sources, 0, "cube", {}, {},
                                        [&](const std::string& warning) { *warnings += warning; });
    for (const ScoreRow& row : run.rows) {
      if (row.metric == "mesh.area") return row.unit;
    }
    return std::string();
  };
  std::string own, theirs;
  EXPECT_EQ(unit_of_area({}, &own), "m2");
  EXPECT_THAT(own, testing::Not(testing::HasSubstr("unit")));
  EXPECT_EQ(unit_of_area({parse_stage_source("poses=dir:" + scratch.path().string())}, &theirs),
            "unit2");
  EXPECT_THAT(theirs, testing::HasSubstr("lengths are in their unit"));
}

TEST(PerceiveViews, ATrainingIsKeptUntilTheRunIsWhole) {
  const ScratchFolder scratch("cousin-views");
  const fs::path out = scratch.path() / "est";
  const auto run = [&](const Progress& progress) {
    return perceive_views(cube_capture(), quick(), 1, {}, 0, "cube", out, progress);
  };
  EXPECT_THROW(run([](const std::string& what, int, int) {
                 if (what == "perceive: depth") throw std::runtime_error("the disk is full");
               }),
               std::runtime_error);
  EXPECT_TRUE(fs::exists(out / "splats.unfinished"));
  int steps = 0;
  run([&](const std::string& what, int, int) {
    steps += what.find("splats, step") != std::string::npos ? 1 : 0;
  });
  EXPECT_LE(steps, 1);
  EXPECT_FALSE(fs::exists(out / "splats.unfinished"));
}

}  // namespace
}  // namespace cousin
