// Depth in another camera's pixels, where its rays meet the surface.
#include "perception/stereo/gathered_depth.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace cousin {
namespace {

/// A depth camera and a colour camera 60 mm beside it before a slope z = 0.5 + 0.5 x.
Capture before_slope() {
  Capture capture;
  capture.rig.resize(2);
  const Camera camera{LensModel::pinhole, 96, 64, 100, 100, 47.5, 31.5, {}, {}};
  capture.rig[0].name = "rgb";
  capture.rig[1].name = "depth";
  for (SensorReport& report : capture.rig) report.camera = camera;
  capture.rig[0].sensor_from_rig.translation_m = {-0.06, 0, 0};
  Frame frame;
  frame.id = 3;
  frame.sensors.resize(2);
  for (SensorFrame& sensor : frame.sensors) sensor.reported = camera;
  frame.sensors[1].depth = Image<std::uint16_t>(96, 64);
  frame.sensors[1].depth_unit_m = 1e-4;
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 96; ++x) {
      const double way = (x - 47.5) / 100;
      frame.sensors[1].depth(x, y) =
          static_cast<std::uint16_t>(std::lround(0.5 / (1 - 0.5 * way) * 1e4));
    }
  }
  capture.frames = {frame};
  return capture;
}

TEST(GatheredDepth, ASlopeIsNoNearerThanItIs) {
  const Depths depths = gathered_depths(before_slope());
  ASSERT_EQ(depths.size(), 1U);
  EXPECT_EQ(depths[0].frame, 3);
  EXPECT_TRUE(depths[0].sigma_m.empty());  // of no infrared pair
  int found = 0;
  double off_m = 0;
  for (int x = 10; x < 80; ++x) {
    const auto z_m = static_cast<double>(depths[0].depth_m(x, 30));
    if (std::isnan(z_m)) continue;
    // In the rig x = 0.06 + z way, z = 0.5 + 0.5 x.
    const double way = (x - 47.5) / 100;
    off_m += z_m - (0.5 + 0.5 * 0.06) / (1 - 0.5 * way);
    ++found;
  }
  EXPECT_GT(found, 60);
  EXPECT_NEAR(off_m / found, 0, 5e-5);  // steps of 0.1 mm; half a pixel's slope is 1.5 mm
}

TEST(GatheredDepth, AcrossAStepThereIsNone) {
  Capture capture = before_slope();
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 96; ++x) capture.frames[0].sensors[1].depth(x, y) = x < 48 ? 5000 : 9000;
  }
  const Image<float> depth_m = gathered_depths(capture)[0].depth_m;
  for (const float z_m : depth_m) {
    if (std::isnan(z_m)) continue;
    EXPECT_TRUE(std::abs(z_m - 0.5F) < 1e-4F || std::abs(z_m - 0.9F) < 1e-4F) << z_m;
  }
}

TEST(GatheredDepth, AFrameWithoutDepthIsEmpty) {
  Capture capture = before_slope();
  capture.frames[0].sensors[1].depth = {};
  EXPECT_TRUE(gathered_depths(capture)[0].depth_m.empty());
}

}  // namespace
}  // namespace cousin
