#include <gtest/gtest.h>

#include "perception/pipelines/seeds.h"

namespace cousin {
namespace {

Capture one_grey_view() {
  Capture capture;
  SensorReport sensor;
  sensor.camera = Camera{LensModel::pinhole, 320, 240, 300, 300, 160, 120, {}};
  capture.rig.push_back(sensor);
  Frame frame;
  frame.sensors.resize(1);
  frame.sensors[0].reported = sensor.camera;
  frame.sensors[0].color = Image<Rgb8>(320, 240, {90, 90, 90});
  capture.frames.push_back(frame);
  return capture;
}

TEST(SeedsPipeline, PlanOfOursReadsOutlinesAndThePapersDoesNot) {
  SeedsPipelineConfig config;
  const PipelineNeeds ours = needs(config);
  EXPECT_EQ(ours.stages, (std::vector<std::string>{"corners", "poses", "depth", "cloud", "clusters",
                                                   "masks", "surfaces", "traits"}));
  config.method = SeedsMethod::paper;
  const PipelineNeeds paper = needs(config);
  EXPECT_EQ(paper.stages, (std::vector<std::string>{"corners", "poses", "depth", "cloud",
                                                    "clusters", "surfaces", "traits"}));
  EXPECT_EQ(paper.left_out.front().first, "masks");
}

TEST(SeedsPipeline, AViewWithoutABoardGivesAStatusAndNoSeeds) {
  const SeedsPipelineConfig config;
  const Estimate estimate = run_seeds(one_grey_view(), config, seeds_stages(config, 1));
  ASSERT_EQ(estimate.corners.size(), 1U);
  EXPECT_NE(estimate.corners[0].status, BoardStatus::ok);
  EXPECT_EQ(estimate.poses.at(0).status, PoseStatus::no_board);
  EXPECT_TRUE(estimate.cloud.empty());
  EXPECT_TRUE(estimate.traits.empty());
  EXPECT_EQ(estimate.timings.size(), 8U);
}

TEST(SeedsPipeline, AStageThatThrowsIsNamedAndEarlierResultsWereHandedOver) {
  const SeedsPipelineConfig config;
  Stages stages = seeds_stages(config, 1);
  stages.depths = [](const Capture&, const Estimate&) -> Depths {
    throw std::runtime_error("no texture");
  };
  std::vector<std::string> finished;
  try {
    run_seeds(one_grey_view(), config, stages,
              [&](std::string_view stage, bool is_finished, const Estimate&) {
                if (is_finished) finished.emplace_back(stage);
              });
    FAIL() << "the failing stage was not reported";
  } catch (const StageError& error) {
    EXPECT_EQ(error.stage, "depth");
    EXPECT_STREQ(error.what(), "stage depth: no texture");
  }
  EXPECT_EQ(finished, (std::vector<std::string>{"corners", "poses"}));
}

TEST(SeedsPipeline, PosesInAnotherOrderThanTheFramesAreRefused) {
  Capture capture;
  capture.rig.push_back({});
  for (const int id : {0, 1, 2}) {
    Frame frame{.id = id};
    frame.sensors.push_back({.color = Image<Rgb8>(32, 32)});
    capture.frames.push_back(frame);
  }
  for (const std::vector<int>& ids : {std::vector{0, 2, 1}, std::vector{0, 1}}) {
    Stages stages;
    stages.poses = [&ids](const Capture&, const Estimate&) {
      Poses poses;
      for (const int id : ids) {
        poses.emplace_back();
        poses.back().frame = id;
      }
      return poses;
    };
    try {
      run_seeds(capture, {}, stages);
      FAIL();
    } catch (const StageError& error) {
      EXPECT_EQ(error.stage, "poses");
      EXPECT_NE(std::string(error.what()).find(ids.size() == 2 ? "2 frames" : "place 1 is frame 2"),
                std::string::npos)
          << error.what();
    }
  }
}

TEST(SeedsPipeline, SigmasOfLengthsFollowTheMedianViewsPixel) {
  const SeedsPipelineConfig config;
  Estimate estimate;
  for (const double distance_m : {0.3, 0.5, 0.8, 90.0}) {
    FramePose pose;
    pose.status = distance_m > 1 ? PoseStatus::not_converged : PoseStatus::ok;
    pose.camera = Camera{LensModel::pinhole, 320, 240, 1000, 1000, 160, 120, {}};
    pose.camera_from_world.translation_m = distance_m * Eigen::Vector3d(0.6, 0, 0.8);
    estimate.poses.push_back(pose);
  }
  Surface surface;
  surface.status = SurfaceStatus::ok;
  // A block: no other box comes near its own.
  for (int i = 0; i < 8; ++i) {
    surface.mesh.vertices_m.emplace_back(i & 1 ? 0.01 : 0.0, i & 2 ? 0.008 : 0.0,
                                         i & 4 ? 0.006 : 0.0);
  }
  surface.mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                            {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  surface.samples_m = {surface.mesh.vertices_m, surface.mesh.vertices_m};  // the fit is certain
  estimate.surfaces = {surface};
  const Traits traits = seeds_stages(config, 1).traits({}, estimate);
  ASSERT_EQ(traits.at(0).status, TraitStatus::ok) << traits[0].reason;
  EXPECT_EQ(traits[0].traits.at(0).name, "length");
  EXPECT_NEAR(traits[0].traits[0].sigma, config.traits.length_sigma_px * 0.5e-3, 1e-9);
  estimate.poses.clear();
  EXPECT_TRUE(std::isnan(seeds_stages(config, 1).traits({}, estimate)[0].traits[0].sigma));
}

TEST(SeedsPipeline, NoFramesAndAForeignBoardAreTheCallersMistakes) {
  const SeedsPipelineConfig config;
  EXPECT_THROW(run_seeds(Capture{}, config, seeds_stages(config, 1)), std::invalid_argument);
  Capture capture = one_grey_view();
  capture.board = "april";
  EXPECT_THROW(board_of(capture, config), std::invalid_argument);
  capture.board = "plain";
  EXPECT_FALSE(board_of(capture, config).has_markers);
}

TEST(SeedsPipeline, EveryKeyIsUniqueAndReadsBack) {
  SeedsPipelineConfig config;
  const Fields all = fields(config);
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) EXPECT_NE(all[i].key, all[j].key);
  }
  for (double SeedsPipelineConfig::*number :
       {&SeedsPipelineConfig::tallest_m, &SeedsPipelineConfig::margin_m,
        &SeedsPipelineConfig::agreement_sigmas, &SeedsPipelineConfig::sensor_size_sigma_m}) {
    SeedsPipelineConfig wrong;
    wrong.*number = -0.005;
    EXPECT_THROW(validate(wrong), std::invalid_argument);
  }
  SeedsPipelineConfig copy;
  read_toml_text(to_toml(all), "own", fields(copy), MissingKeys::error);
  EXPECT_EQ(to_toml(fields(copy)), to_toml(all));
}

}  // namespace
}  // namespace cousin
