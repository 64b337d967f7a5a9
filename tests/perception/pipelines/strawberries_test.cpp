// Boxes and a depth image become points, each of its own box.
#include "perception/pipelines/strawberries.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "perception/pipelines/pipeline_table.h"

namespace cousin {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

/// A colour camera that hands over depth in its own pixels: a wall at half a metre.
Capture wall(int frames) {
  Capture capture;
  capture.rig.resize(1);
  capture.rig[0].camera = Camera{LensModel::pinhole, 64, 48, 80, 80, 31.5, 23.5, {}, {}};
  for (int f = 0; f < frames; ++f) {
    Frame frame;
    frame.id = 10 + f;
    SensorFrame sensor;
    sensor.reported = capture.rig[0].camera;
    sensor.color = Image<Rgb8>(64, 48);
    sensor.depth = Image<std::uint16_t>(64, 48, 500);
    frame.sensors = {sensor};
    capture.frames.push_back(frame);
  }
  return capture;
}

DetectedBox box_at(int id, int frame, double x, double y) {
  DetectedBox box;
  box.id = id;
  box.frame = frame;
  box.low_px = {x - 8.5, y - 8.5};
  box.high_px = {x + 8.5, y + 8.5};
  return box;
}

Estimate run_with(const Capture& capture, const Boxes& boxes, const char* method) {
  PipelineConfig config = StrawberriesPipelineConfig{};
  set_field(fields(config), std::string("method=") + method);
  Stages stages = stages_for(config, capture, 1);
  stages.boxes = [&](const Capture&, const Estimate&) { return boxes; };
  return run_pipeline(capture, config, stages);
}

TEST(StrawberriesPipeline, APointOfEachBoxIsInTheAxesOfItsImage) {
  const Capture capture = wall(2);
  const Boxes boxes = {box_at(7, 10, 31.5, 23.5), box_at(8, 11, 47.5, 15.5)};
  for (const char* method : {"ours", "paper"}) {
    SCOPED_TRACE(method);
    const Traits traits = run_with(capture, boxes, method).traits;
    ASSERT_EQ(traits.size(), 2U);
    EXPECT_EQ(traits[1].instance, 8);
    EXPECT_EQ(traits[1].frame, 11);
    ASSERT_EQ(traits[1].status, TraitStatus::ok) << traits[1].reason;
    ASSERT_EQ(traits[1].traits.size(), 4U);
    // The pixel under the middle: (47, 15).
    EXPECT_NEAR(traits[1].traits[0].value, 0.5 * (47 - 31.5) / 80, 1e-6);
    EXPECT_NEAR(traits[1].traits[1].value, 0.5 * (15 - 23.5) / 80, 1e-6);
    EXPECT_NEAR(traits[1].traits[2].value, 0.5, 1e-6);
    EXPECT_EQ(std::isfinite(traits[1].traits[2].sigma), std::string(method) == "ours");
  }
}

TEST(StrawberriesPipeline, BoxesOfOtherSensorsAreNotMeasuredAndForeignFramesRefused) {
  const Capture capture = wall(1);
  DetectedBox other = box_at(1, 10, 31.5, 23.5);
  other.sensor = 1;
  EXPECT_TRUE(run_with(capture, {other}, "ours").traits.empty());
  EXPECT_THAT([&] { run_with(capture, {box_at(3, 99, 31.5, 23.5)}, "ours"); },
              ThrowsMessage<StageError>(HasSubstr("box 3 is of frame 99")));
}

TEST(StrawberriesPipeline, ACaptureWithoutDepthIsRefusedByName) {
  Capture capture = wall(1);
  capture.frames[0].sensors[0].depth = {};
  EXPECT_THAT([&] { run_with(capture, {}, "paper"); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("paper of strawberries reads depth")));
}

}  // namespace
}  // namespace cousin
