// Boxes, masks and a depth image become sizes, each of its own box.
#include "perception/pipelines/apples.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "perception/fruit/fruit_seam.h"
#include "perception/pipelines/pipeline_table.h"
#include "tests/perception/fruit/drawn_fruit.h"

namespace cousin {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

/// A colour camera that hands over depth in its own pixels, and a fruit before a wall.
struct Orchard {
  Capture capture;
  Boxes boxes;
};
Orchard one_apple() {
  const DrawnFruit drawn = draw_fruit(apple_at_half_a_metre(0.2), 0, Rng(1));
  Orchard made;
  made.capture.rig.resize(1);
  made.capture.rig[0].camera = kFruitCamera;
  Frame frame;
  frame.id = 10;
  SensorFrame sensor;
  sensor.reported = kFruitCamera;
  sensor.color = Image<Rgb8>(kFruitCamera.width_px, kFruitCamera.height_px);
  sensor.depth = Image<std::uint16_t>(kFruitCamera.width_px, kFruitCamera.height_px);
  sensor.depth_unit_m = 1e-4;
  for (std::size_t i = 0; i < sensor.depth.size(); ++i)
    sensor.depth.data()[i] =
        static_cast<std::uint16_t>(std::lround(drawn.depth.depth_m.data()[i] * 1e4F));
  frame.sensors = {sensor};
  made.capture.frames = {frame};
  made.boxes = {drawn.box};
  made.boxes[0].id = 7;
  made.boxes[0].frame = 10;
  return made;
}

Estimate run_apples(const Orchard& orchard, const std::string& method) {
  PipelineConfig config = ApplesPipelineConfig{};
  set_field(fields(config), "method=" + method);
  Stages stages = stages_for(config, orchard.capture, 1);
  stages.boxes = [&](const Capture&, const Estimate&) { return orchard.boxes; };
  return run_pipeline(orchard.capture, config, stages);
}

TEST(ApplesPipeline, EachMethodMeasuresAFreeApple) {
  const Orchard orchard = one_apple();
  const double truth_m3 = numbers_of(apple_at_half_a_metre(0.2)).volume_m3.value;
  for (const MethodRow& method : pipeline_row("apples").methods) {
    SCOPED_TRACE(method.name);
    const Estimate estimate = run_apples(orchard, std::string(method.name));
    ASSERT_EQ(estimate.traits.size(), 1U);
    const SpecimenTraits& apple = estimate.traits[0];
    EXPECT_EQ(apple.instance, 7);
    EXPECT_EQ(apple.frame, 10);
    if (method.name == "ellipsoid" && apple.status != TraitStatus::ok) continue;  // it says why
    ASSERT_EQ(apple.status, TraitStatus::ok) << apple.reason;
    ASSERT_EQ(apple.traits.size(), 4U);
    EXPECT_EQ(apple.traits[2].name, "volume");
    EXPECT_EQ(std::isfinite(apple.traits[3].sigma), method.name == "ours");
    if (method.name == "hull") {  // of what is seen: it has no rim, and lacks what follows
      EXPECT_LT(apple.traits[2].value, truth_m3);
      continue;
    }
    const double most = method.name == "ours" ? 0.03 : 0.6;
    EXPECT_NEAR(apple.traits[2].value, truth_m3, most * truth_m3);
  }
}

TEST(ApplesPipeline, AFitIsTheShapeAgain) {
  const Estimate estimate = run_apples(one_apple(), "ours");
  ASSERT_EQ(estimate.fits.size(), 1U);
  const FruitShape shape = shape_of(estimate.fits[0]);
  EXPECT_NEAR(numbers_of(shape).volume_m3.value, estimate.traits[0].traits[2].value, 1e-9);
  EXPECT_LT((shape.centre_m() - apple_at_half_a_metre(0.2).centre_m()).norm(), 0.003);
}

TEST(ApplesPipeline, WhatIsNotMeasuredHasAReasonAndWhatIsKnownOfTheKind) {
  Orchard orchard = one_apple();
  for (std::uint16_t& code : orchard.capture.frames[0].sensors[0].depth) code = 0;
  const SpecimenTraits apple = run_apples(orchard, "ours").traits.at(0);
  EXPECT_EQ(apple.status, TraitStatus::not_solved);
  EXPECT_THAT(apple.reason, HasSubstr("inner pixels have depth"));
  ASSERT_EQ(apple.traits.size(), 4U);
  EXPECT_GT(apple.traits[3].sigma, 0.2 * apple.traits[3].value);
}

TEST(ApplesPipeline, BoxesOfOtherSensorsAreNotMeasuredAndForeignFramesRefused) {
  Orchard orchard = one_apple();
  orchard.boxes[0].sensor = 1;
  EXPECT_TRUE(run_apples(orchard, "ours").traits.empty());
  orchard.boxes[0].sensor = 0;
  orchard.boxes[0].frame = 99;
  EXPECT_THAT([&] { run_apples(orchard, "ours"); },
              ThrowsMessage<StageError>(HasSubstr("box 7 is of frame 99")));
}

TEST(ApplesPipeline, ACaptureWithoutDepthIsRefusedByName) {
  Orchard orchard = one_apple();
  orchard.capture.frames[0].sensors[0].depth = {};
  EXPECT_THAT([&] { run_apples(orchard, "paper"); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("paper of apples reads depth")));
}

}  // namespace
}  // namespace cousin
