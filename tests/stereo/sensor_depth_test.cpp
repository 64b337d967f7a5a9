#include "perception/stereo/sensor_depth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace cousin {
namespace {

Camera pinhole(int width_px, int height_px, double focal_px) {
  Camera camera;
  camera.width_px = width_px;
  camera.height_px = height_px;
  camera.fx_px = camera.fy_px = focal_px;
  camera.cx_px = 0.5 * (width_px - 1);
  camera.cy_px = 0.5 * (height_px - 1);
  return camera;
}

Pose at_x(double x_m) {
  Pose sensor_from_rig;
  sensor_from_rig.translation_m.x() = -x_m;
  return sensor_from_rig;
}

/// A wall at 0.5 m before a rig whose colour camera is 30 mm to the right of its depth sensor.
Capture wall() {
  Capture capture;
  const Camera color = pinhole(200, 150, 200), imager = pinhole(160, 120, 160);
  capture.rig = {
      {.name = "rgb", .camera = color, .sensor_from_rig = at_x(0.03), .raw_format = {}},
      {.name = "ir_left", .camera = imager, .sensor_from_rig = {}, .raw_format = {}},
      {.name = "ir_right", .camera = imager, .sensor_from_rig = at_x(0.05), .raw_format = {}},
      {.name = "depth", .camera = imager, .sensor_from_rig = {}, .raw_format = {}}};
  for (int i = 0; i < 2; ++i) {
    Frame frame;
    frame.id = 4 * i;
    frame.rig_from_world = Pose{};
    frame.sensors.resize(4);
    for (std::size_t s = 0; s < 4; ++s) frame.sensors[s].reported = capture.rig[s].camera;
    frame.sensors[3].depth = Image<std::uint16_t>(160, 120, 5000);
    frame.sensors[3].depth_unit_m = 0.0001;
    capture.frames.push_back(frame);
  }
  return capture;
}

const DepthVolume kEverything{Eigen::Vector3d::Constant(-10), Eigen::Vector3d::Constant(10)};

TEST(SensorDepth, IsInTheColourImagesPixelsWithTheSigmaOfStereo) {
  const Capture capture = wall();
  const Poses poses = poses_of_rig(capture);
  const Depths depths = depths_of_sensor(capture, poses, kEverything, {.sigma_px = 0.1});
  ASSERT_EQ(depths.size(), 2U);
  EXPECT_EQ(depths[1].frame, 4);
  const Image<float>& depth_m = depths[0].depth_m;
  ASSERT_EQ(depth_m.width(), 200);
  EXPECT_FLOAT_EQ(depth_m(100, 75), 0.5F);
  // Z^2 sigma / (f B) = 0.25 * 0.1 / (160 * 0.05).
  EXPECT_NEAR(depths[0].sigma_m(100, 75), 0.25 * 0.1 / 8, 1e-7);
  // The wall's right end as the sensor sees it, x = 80 / 160 * 0.5 m, less 0.03 m, at 0.5 m through
  // f = 200 px: 88 px to the right of the middle.
  EXPECT_FALSE(std::isnan(depth_m(99 + 86, 75)));
  EXPECT_TRUE(std::isnan(depth_m(99 + 91, 75)));
}

TEST(SensorDepth, OutsideTheVolumeAndBeyondTheLargestSigmaThereIsNone) {
  const Capture capture = wall();
  const Poses poses = poses_of_rig(capture);
  const auto count = [&](const DepthVolume& volume, const SensorDepthConfig& config) {
    const Depths depths = depths_of_sensor(capture, poses, volume, config);
    return std::count_if(depths[0].depth_m.begin(), depths[0].depth_m.end(),
                         [](float z) { return !std::isnan(z); });
  };
  const auto all = count(kEverything, {});
  EXPECT_GT(all, 20000);
  // The rig's frame is the world's: half of the wall has x > 0.03 in it, where the camera's middle
  // is.
  const DepthVolume right{{0.03, -10, -10}, {10, 10, 10}};
  EXPECT_NEAR(static_cast<double>(count(right, {})), 0.46 * static_cast<double>(all),
              0.03 * static_cast<double>(all));
  EXPECT_EQ(count(kEverything, {.sigma_px = 0.1, .max_sigma_m = 0.003}), 0);
}

TEST(SensorDepth, AFrameWithoutPoseOrDepthIsEmpty) {
  Capture capture = wall();
  capture.frames[0].rig_from_world.reset();
  capture.frames[1].sensors[3].depth = {};
  const Poses poses = poses_of_rig(capture);
  EXPECT_EQ(poses[0].status, PoseStatus::no_board);
  EXPECT_EQ(poses[1].status, PoseStatus::ok);
  EXPECT_LT((poses[1].camera_from_world.translation_m - Eigen::Vector3d(-0.03, 0, 0)).norm(),
            1e-15);
  for (const FrameDepth& depth : depths_of_sensor(capture, poses, kEverything))
    EXPECT_TRUE(depth.depth_m.empty());
  EXPECT_TRUE(has_sensor_depth(capture));
  capture.frames[0].sensors[3].depth = {};
  EXPECT_FALSE(has_sensor_depth(capture));
  EXPECT_TRUE(has_sensor_depth(wall()));
  EXPECT_THROW(depths_of_sensor(capture, {}, kEverything), std::invalid_argument);
}

TEST(SensorDepth, WithoutASensorOfThatNameTheFirstThatHasDepthCounts) {
  Capture capture = wall();
  capture.rig.resize(1);
  for (Frame& frame : capture.frames) {
    frame.sensors.resize(1);
    frame.sensors[0].depth = Image<std::uint16_t>(200, 150, 700);
    frame.sensors[0].depth_unit_m = 0.001;
  }
  const Depths depths = depths_of_sensor(capture, poses_of_rig(capture), kEverything);
  EXPECT_FLOAT_EQ(depths[0].depth_m(20, 20), 0.7F);
  EXPECT_TRUE(depths[0].sigma_m.empty());  // nothing says what its baseline is
}

}  // namespace
}  // namespace cousin
