// Each stage of the table: its member, its files, what is left of them.
#include "perception/pipelines/stage_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "perception/pipelines/seeds.h"
#include "perception/pipelines/views.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::ThrowsMessage;

Capture one_frame() {
  Capture capture;
  capture.frames.resize(1);
  capture.frames[0].sensors.resize(1);
  return capture;
}

/// Something in every seam.
Estimate something() {
  Estimate estimate;
  estimate.corners.resize(1);
  estimate.poses.resize(1);
  estimate.poses[0].camera = Camera{LensModel::opencv5, 4, 4, 4, 4, 2, 2, {}};
  estimate.splats.splats.resize(1);
  estimate.splats.splats[0] = {};
  estimate.depths = {
      {.frame = 0, .depth_m = Image<float>(2, 2, 1.0F), .sigma_m = {}, .normal = {}}};
  CloudPoint point;
  point.position_m = {0, 0, 1};
  estimate.cloud = {point};
  estimate.clusters = {{point}, {0}, 1};
  Silhouette mask;
  for (const auto& [x, y] : {std::pair(0.F, 0.F), {1.F, 0.F}, {1.F, 1.F}})
    mask.outline.push_back({{x, y}, {1, 0}, 0.1F, true});
  estimate.silhouettes = {mask};
  DetectedBox box;
  box.high_px = {1, 1};
  estimate.boxes = {box};
  estimate.keypoints.resize(1);
  ObjectFit fit;
  fit.model = "sphere";
  estimate.fits = {fit};
  Surface surface;
  surface.points_m = {{0, 0, 0}};
  estimate.surfaces = {surface};
  SpecimenTraits specimen;
  specimen.reason = "none";
  estimate.traits = {specimen};
  return estimate;
}

TEST(StageTable, WhatAStageWritesIsReadInItsPlaceAndRemoved) {
  const Estimate estimate = something();
  for (const StageRow& stage : stage_table()) {
    SCOPED_TRACE(stage.name);
    const TemporaryFolder folder;
    stage.write(folder.path(), estimate, 0);
    EXPECT_FALSE(fs::is_empty(folder.path()));

    Stages stages;
    EXPECT_FALSE(stage.is_there(stages));
    stage.read_from(stages,
                    [&](const Capture&, const Estimate&) {
                      return std::make_shared<const fs::path>(folder.path());
                    },
                    0, {});
    EXPECT_TRUE(stage.is_there(stages));
    Estimate read;
    Capture capture = one_frame();
    capture.frames[0].sensors[0].reported = Camera{LensModel::opencv5, 4, 4, 4, 4, 2, 2, {}};
    stage.run(stages, capture, read);
    const TemporaryFolder again;
    stage.write(again.path(), read, 0);
    EXPECT_FALSE(fs::is_empty(again.path())) << "the seam was not kept in its member";

    Stages other;
    stage.replace(other, stages);
    EXPECT_TRUE(stage.is_there(other));
    stage.leave_out(other);
    EXPECT_FALSE(stage.is_there(other));

    remove_seam(folder.path(), stage);
    EXPECT_TRUE(fs::is_empty(folder.path()));
  }
}

TEST(StageTable, NamesAreOfTheTableAndOnce) {
  std::set<std::string_view> names;
  for (const StageRow& stage : stage_table()) {
    EXPECT_TRUE(names.insert(stage.name).second) << stage.name;
    for (const std::string_view needless : stage.makes_needless)
      EXPECT_EQ(stage_row(needless).name, needless);
  }
  for (const StageOrder order : {seeds_stage_order(), views_stage_order()}) {
    for (const std::string_view name : order) EXPECT_EQ(stage_row(name).name, name);
  }
  EXPECT_THAT([] { stage_row("dept"); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("is not one of corners, poses")));
}

TEST(StageTable, AStageRunsInTheOrderOfItsPipeline) {
  std::string order;
  Stages stages;
  stages.cloud = [&](const Capture&, const Estimate&) { return order += "c", Cloud{}; };
  stages.traits = [&](const Capture&, const Estimate&) { return order += "t", Traits{}; };
  const std::string_view forward[] = {"cloud", "depth", "traits"};
  const std::string_view backward[] = {"traits", "cloud"};
  run_stages(one_frame(), stages, forward);
  run_stages(one_frame(), stages, backward);
  EXPECT_EQ(order, "cttc");
}

TEST(StageTable, FramesThatAreNotTheCapturesAreRefused) {
  Stages stages;
  stages.poses = [](const Capture&, const Estimate&) { return Poses{}; };
  const std::string_view order[] = {"poses"};
  EXPECT_THAT([&] { run_stages(one_frame(), stages, order); },
              ThrowsMessage<StageError>(HasSubstr("stage poses: 0 frames; the capture has 1")));
}

TEST(StageTable, WhatIsKnownWithoutThemIsLeftOut) {
  Stages stages = seeds_stages({}, 1);
  stages.splats = [](const Capture&, const Estimate&) { return SplatModel{}; };
  leave_out_needless(stages, {"corners", "depth"});
  EXPECT_FALSE(stages.splats);
  EXPECT_TRUE(stages.depths && stages.cloud);
  leave_out_needless(stages, {"clusters"});
  EXPECT_FALSE(stages.depths || stages.cloud);
  EXPECT_TRUE(stages.silhouettes && stages.traits);
}

}  // namespace
}  // namespace cousin
