#include "perception/pipelines/stereo.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "perception/pipelines/pipeline_table.h"
#include "tests/perception/stereo/drawn_pair.h"

namespace cousin {
namespace {

using testing::HasSubstr;

/// Two frames of a plane: disparity 20 px everywhere, 320 px focal length and 0.1 m: 1.6 m.
Capture plane_twice() {
  Capture capture = capture_of(draw_pair({{.at_px = 20}}));
  capture.frames.push_back(capture.frames[0]);
  capture.frames[1].id = 7;
  return capture;
}

Estimate run(const Capture& capture, const StereoPipelineConfig& config = {}) {
  const PipelineConfig pipeline(config);
  return run_pipeline(capture, pipeline, stages_for(pipeline, capture, 1, {}));
}

TEST(StereoPipeline, OfFramesWithoutPosesTheFirstMakesTheCloud) {
  const Estimate estimate = run(plane_twice());
  ASSERT_EQ(estimate.depths.size(), 2U);
  EXPECT_EQ(estimate.depths[1].frame, 7);
  EXPECT_THAT(*estimate.notes, testing::ElementsAre(HasSubstr("cloud is of frame 0 alone")));
  ASSERT_GT(estimate.cloud.size(), 50'000U);
  double off_m = 0;
  for (const CloudPoint& point : estimate.cloud) {
    off_m += std::abs(static_cast<double>(point.position_m.z()) - 1.6);
    EXPECT_GT(point.sigma_m, 0);
  }
  EXPECT_LT(off_m / static_cast<double>(estimate.cloud.size()), 0.01);
  // Its normals are towards the camera.
  EXPECT_LT(estimate.cloud[estimate.cloud.size() / 2].normal.z(), 0);
}

TEST(StereoPipeline, WhereTheRigSaysWhereItIsAllFramesMakeIt) {
  Capture capture = plane_twice();
  capture.frames[0].rig_from_world = Pose{};
  Pose moved;
  moved.translation_m.x() = -1;  // the rig stands at x = 1
  capture.frames[1].rig_from_world = moved;
  const Estimate estimate = run(capture);
  EXPECT_TRUE(estimate.notes->empty());
  float most = 0;
  for (const CloudPoint& point : estimate.cloud) most = std::max(most, point.position_m.x());
  EXPECT_NEAR(static_cast<double>(most), 1 + 0.8, 0.05);
}

TEST(StereoPipeline, AFrameThatSaysNotWhereItWasIsNotInTheWorldsCloud) {
  Capture capture = plane_twice();
  capture.frames[0].rig_from_world = Pose{};
  const Estimate estimate = run(capture);
  EXPECT_THAT(*estimate.notes, testing::ElementsAre(HasSubstr("1 frames do not say where")));
}

TEST(StereoPipeline, SomebodysDepthOfAnotherSizeMakesNoCloud) {
  const Capture capture = plane_twice();
  const PipelineConfig pipeline{StereoPipelineConfig{}};
  Stages stages = stages_for(pipeline, capture, 1, {});
  stages.depths = [](const Capture& of, const Estimate&) {
    Depths depths;
    for (const Frame& frame : of.frames) depths.push_back({frame.id, Image<float>(160, 120, 1.6F)});
    return depths;
  };
  try {
    run_pipeline(capture, pipeline, stages);
    ADD_FAILURE() << "a cloud of a half-size depth";
  } catch (const StageError& error) {
    EXPECT_THAT(error.what(), HasSubstr("160 x 120"));
  }
}

TEST(StereoPipeline, ACloudHasAboutAsManyPointsAsAskedFor) {
  const std::size_t points = run(plane_twice(), {.cloud_points = 5000}).cloud.size();
  EXPECT_GT(points, 2500U);  // every second pixel more or less is a factor of two
  EXPECT_LE(points, 5100U);
  const StereoPipelineConfig none{.cloud_points = 0};
  EXPECT_TRUE(run(plane_twice(), none).cloud.empty());
  EXPECT_THAT(needs(none).left_out, testing::ElementsAre(testing::Pair("cloud", "cloud_points=0")));
}

TEST(StereoPipeline, AFrameThatIsNoPairIsLeftOutAndACaptureOfSuchFramesFails) {
  Capture capture = plane_twice();
  capture.frames[0].sensors[1].time_s = capture.frames[0].time_s + 1;
  const Estimate estimate = run(capture);
  EXPECT_TRUE(estimate.depths[0].depth_m.empty());
  EXPECT_FALSE(estimate.depths[1].depth_m.empty());
  EXPECT_THAT(*estimate.notes, testing::ElementsAre(HasSubstr("frame 0: no depth")));
  capture.frames.pop_back();
  try {
    run(capture);
    ADD_FAILURE() << "depth of no pair";
  } catch (const StageError& error) {
    EXPECT_EQ(error.stage, "depth");
    EXPECT_THAT(error.what(), HasSubstr("apart"));
  }
}

TEST(StereoPipeline, OneCameraIsRefusedBeforeAnyWork) {
  Capture capture = plane_twice();
  capture.rig.pop_back();
  EXPECT_THROW(run(capture), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
