#include "perception/stereo/sensor_depth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sim/types/rng.h"

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

/// Depth of a plate of 0.2 m, 0.5 m before a camera that looks straight at it, in its own pixels:
/// off by `offset_m`, noisy, with an object of 20 mm on a tenth of it.
Image<float> plate_depth(double offset_m, double sigma_m, FramePose& pose) {
  pose.camera = pinhole(160, 120, 160);
  pose.status = PoseStatus::ok;
  // World z up: the camera at z = 0.5 looks down.
  pose.camera_from_world.rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(3.14159265358979, Eigen::Vector3d::UnitX()));
  pose.camera_from_world.translation_m = Eigen::Vector3d(0, 0, 0.5);
  Image<float> depth_m(160, 120);
  Rng rng(4);
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      const bool is_object = x > 70 && x < 86 && y > 50 && y < 66;
      depth_m(x, y) =
          static_cast<float>(0.5 + offset_m + sigma_m * normal(rng) - (is_object ? 0.02 : 0));
    }
  }
  return depth_m;
}

TEST(SensorDepth, ThePlateTellsHowFarAFramesDepthsAreOff) {
  FramePose pose;
  const Image<float> depth_m = plate_depth(0.003, 0.001, pose);
  const PlateResidual plate = plate_residual(depth_m, pose, 0.2);
  // 0.15 m of 0.2 m at 160 px and 0.5 m: 48 px a side, 2300 pixels less 225 of the object.
  EXPECT_NEAR(plate.pixels, 49 * 49, 100);
  // The median of 2000 is known to 1.25 / sqrt(2000) = 2.8 % of a sigma, the robust spread to 2.6
  // %; allow four. Clipping at 3 sigmas takes 1 % off.
  EXPECT_NEAR(plate.offset_m, 0.003, 4 * 0.028e-3);
  EXPECT_NEAR(plate.sigma_m, 0.001, 4 * 0.026e-3 + 0.01e-3);
  EXPECT_EQ(plate_residual(Image<float>(160, 120, NAN), pose, 0.2).pixels, 0);
}

TEST(SensorDepth, AFrameIsMovedOntoThePlateAndItsSigmaIsAtLeastTheSpreadAboutIt) {
  FramePose pose;
  const Image<float> depth_m = plate_depth(0.003, 0.001, pose);
  Capture capture;  // a sensor that says nothing of a baseline
  capture.rig = {{.name = "depth", .camera = pose.camera, .sensor_from_rig = {}, .raw_format = {}}};
  Frame& frame = capture.frames.emplace_back();
  frame.sensors.resize(1);
  frame.sensors[0].reported = pose.camera;
  frame.sensors[0].depth_unit_m = 0.0001;
  frame.sensors[0].depth = Image<std::uint16_t>(160, 120);
  for (std::size_t i = 0; i < depth_m.size(); ++i) {
    frame.sensors[0].depth.data()[i] =
        static_cast<std::uint16_t>(std::lround(double(depth_m.data()[i]) * 1e4));
  }
  DepthVolume volume{Eigen::Vector3d::Constant(-1), Eigen::Vector3d::Constant(1), 0.2};
  const auto mean_m = [&](const SensorDepthConfig& config) {
    const Depths depths = depths_of_sensor(capture, {pose}, volume, config);
    double sum = 0;
    for (int y = 80; y < 90; ++y)
      for (int x = 60; x < 100; ++x) sum += static_cast<double>(depths[0].depth_m(x, y)) / 400;
    return sum;
  };
  // 400 pixels of 1 mm, and the offset's own 0.03 mm.
  EXPECT_NEAR(mean_m({}), 0.5, 4 * 0.06e-3);
  EXPECT_NEAR(mean_m({.level_on_plate = false}), 0.503, 4 * 0.05e-3);
  EXPECT_NEAR(static_cast<double>(depths_of_sensor(capture, {pose}, volume)[0].sigma_m(80, 85)),
              0.001, 0.12e-3);
  volume.plate_m = 0;  // nothing to hold it against
  EXPECT_NEAR(mean_m({}), 0.503, 4 * 0.05e-3);
  EXPECT_TRUE(depths_of_sensor(capture, {pose}, volume)[0].sigma_m.empty());
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
