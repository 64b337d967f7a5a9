// Boxes and a depth image become points, each of its own box.
#include "perception/pipelines/strawberries.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "perception/pipelines/pipeline_table.h"
#include "tests/perception/fruit/drawn_fruit.h"

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
    ASSERT_GE(traits[1].traits.size(), 4U);
    EXPECT_EQ(traits[1].traits[0].name, "point_x");
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

/// A ripe strawberry of the prior's mean before a wall, its stalk a little away from the camera.
struct Hanging {
  FruitShape shape = mean_shape(strawberry_prior());
  Capture capture;
  Boxes boxes;
};
Hanging one_strawberry() {
  Hanging made;
  made.shape.camera_from_fruit =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), Eigen::Vector3d(0.1, -1, 0.2))
          .toRotationMatrix();
  made.shape.numbers.head<3>() = Eigen::Vector3d(0.01, -0.01, 0.4);
  const DrawnFruit drawn = draw_fruit(made.shape, 0, Rng(1));
  made.capture.rig.resize(1);
  made.capture.rig[0].camera = kFruitCamera;
  SensorFrame sensor;
  sensor.reported = kFruitCamera;
  sensor.color = Image<Rgb8>(kFruitCamera.width_px, kFruitCamera.height_px, Rgb8{180, 20, 20});
  sensor.depth = Image<std::uint16_t>(kFruitCamera.width_px, kFruitCamera.height_px);
  sensor.depth_unit_m = 1e-4;
  for (std::size_t i = 0; i < sensor.depth.size(); ++i)
    sensor.depth.data()[i] =
        static_cast<std::uint16_t>(std::lround(drawn.depth.depth_m.data()[i] * 1e4F));
  Frame frame;
  frame.id = 10;
  frame.sensors = {sensor};
  made.capture.frames = {frame};
  made.boxes = {drawn.box};
  made.boxes[0].id = 7;
  made.boxes[0].frame = 10;
  return made;
}

double value_of(const SpecimenTraits& traits, const std::string& name) {
  for (const Trait& trait : traits.traits) {
    if (trait.name == name) return trait.value;
  }
  return kNaN;
}

Eigen::Vector3d place_of(const SpecimenTraits& traits, const std::string& name) {
  return {value_of(traits, name + "_x"), value_of(traits, name + "_y"),
          value_of(traits, name + "_z")};
}

TEST(StrawberriesPipeline, OursFindsWhereToCutAndHowLargeItIs) {
  const Hanging hanging = one_strawberry();
  const FruitPlaces truth = places_of(hanging.shape, FruitCovariance::Zero());
  const FruitNumbers sizes = numbers_of(hanging.shape);
  const Estimate estimate = run_with(hanging.capture, hanging.boxes, "ours");
  ASSERT_EQ(estimate.traits.size(), 1U);
  const SpecimenTraits& own = estimate.traits[0];
  ASSERT_EQ(own.status, TraitStatus::ok) << own.reason;
  EXPECT_LT((place_of(own, "centre") - truth.centre.point_m).norm(), 0.0015);
  EXPECT_LT((place_of(own, "calyx") - truth.calyx.point_m).norm(), 0.003);
  EXPECT_LT((place_of(own, "cut") - truth.cut.point_m).norm(), 0.004);
  EXPECT_GT(place_of(own, "axis").dot(truth.axis), std::cos(0.15));
  EXPECT_NEAR(value_of(own, "length"), sizes.length_m.value, 0.03 * sizes.length_m.value);
  EXPECT_NEAR(value_of(own, "diameter"), sizes.diameter_m.value, 0.03 * sizes.diameter_m.value);
  const double volume_m3 = strawberry_prior().solid_share * sizes.volume_m3.value;
  EXPECT_NEAR(value_of(own, "volume"), volume_m3, 0.05 * volume_m3);
  EXPECT_EQ(value_of(own, "red_share"), 1);
  for (const Trait& trait : own.traits) EXPECT_GT(trait.sigma, 0) << trait.name;
}

TEST(StrawberriesPipeline, BodiesThatFillTheBoxHaveASizeAndThePapersRuleNone) {
  const Hanging hanging = one_strawberry();
  const double length_m = numbers_of(hanging.shape).length_m.value;
  double volume_m3[2] = {};
  int at = 0;
  for (const char* method : {"ellipsoid", "cone"}) {
    SCOPED_TRACE(method);
    const SpecimenTraits own = run_with(hanging.capture, hanging.boxes, method).traits.at(0);
    EXPECT_NEAR(value_of(own, "length"), length_m, 0.1 * length_m);
    EXPECT_LT((place_of(own, "axis") - Eigen::Vector3d(0, -1, 0)).norm(), 1e-12);
    EXPECT_LT((place_of(own, "centre") - hanging.shape.centre_m()).norm(), 0.006);
    volume_m3[at++] = value_of(own, "volume");
  }
  EXPECT_NEAR(volume_m3[1] / volume_m3[0], (1 + 0.4 + 0.16) / 2, 1e-9);
  const Estimate paper = run_with(hanging.capture, hanging.boxes, "paper");
  EXPECT_TRUE(paper.fits.empty());
  EXPECT_EQ(paper.traits.at(0).traits.size(), 4U);
}

TEST(StrawberriesPipeline, AFruitThatTheSensorHardlySeesIsNotAsserted) {
  Hanging hanging = one_strawberry();
  auto& depth = hanging.capture.frames[0].sensors[0].depth;
  for (std::size_t i = 0; i < depth.size(); ++i) {
    if (i % 3 != 0) depth.data()[i] = 0;
  }
  const SpecimenTraits own = run_with(hanging.capture, hanging.boxes, "ours").traits.at(0);
  EXPECT_TRUE(std::isnan(value_of(own, "cut_x")));
  EXPECT_THAT(own.reason, HasSubstr("inner pixels have depth"));
}

TEST(StrawberriesPipeline, ACaptureWithoutDepthIsRefusedByName) {
  Capture capture = wall(1);
  capture.frames[0].sensors[0].depth = {};
  EXPECT_THAT([&] { run_with(capture, {}, "paper"); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("paper of strawberries reads depth")));
}

}  // namespace
}  // namespace cousin
