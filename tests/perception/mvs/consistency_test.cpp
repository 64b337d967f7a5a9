#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "perception/mvs/reference_depth.h"

namespace cousin {
namespace {

/// Looks along z from (x, 0, 0); the principal point is at an integer pixel.
Frame frame_of(int id, double focal_px, double x_m) {
  Frame frame{.id = id};
  Camera camera;
  camera.width_px = 2000;
  camera.height_px = 120;
  camera.fx_px = camera.fy_px = focal_px;
  camera.cx_px = 1000;
  camera.cy_px = 60;
  frame.sensors.push_back({.reported = camera, .color = Image<Rgb8>(2000, 120)});
  frame.rig_from_world = Pose{Eigen::Quaterniond::Identity(), {-x_m, 0, 0}};
  return frame;
}

/// A plane that faces the camera.
ReferenceDepth plane_at(const MvsView& view, float depth_m) {
  ReferenceDepth depth;
  const int width = view.rect.width, height = view.rect.height;
  depth.inverse_depth = Image<float>(width, height, 1 / depth_m);
  depth.slope_x = depth.slope_y = Image<float>(width, height, 0.0F);
  depth.score = Image<float>(width, height, 1.0F);
  depth.sigma_m = Image<float>(width, height, 0.0F);
  return depth;
}

std::size_t kept(const Image<float>& depth_m) {
  return static_cast<std::size_t>(
      std::count_if(depth_m.begin(), depth_m.end(), [](float d) { return std::isfinite(d); }));
}

// At 0.5 m, 0.2 m apart, 0.6 mm of depth are two pixels of the long lens and half a pixel of the
// short one.
TEST(Consistency, IsMeasuredInTheImageWhoseDepthItIs) {
  Capture capture;
  capture.frames = {frame_of(0, 4000, 0), frame_of(1, 1000, 0.2)};
  capture.rig.push_back({.camera = capture.frames[0].sensors[0].reported});
  Poses poses;
  for (const Frame& frame : capture.frames) {
    FramePose pose;
    pose.frame = frame.id;
    pose.status = PoseStatus::ok;
    pose.camera_from_world = *frame.rig_from_world;
    pose.camera = frame.sensors[0].reported;
    poses.push_back(pose);
  }
  const SweepVolume volume{{0.09, -0.002, 0.49}, {0.11, 0.002, 0.51}};
  std::vector<MvsView> views;
  for (const int i : {0, 1}) {
    auto view = prepare_view(capture, poses, i, volume);
    ASSERT_TRUE(view);
    views.push_back(std::move(*view));
  }
  MvsConfig config;
  config.consistent_views = 1;
  config.consistency_px = 1;
  config.consistency_depth = 0.1;
  const auto depths = consistent_depths_m(
      views, {0, 1}, {plane_at(views[0], 0.5F), plane_at(views[1], 0.50062F)}, config);
  EXPECT_EQ(kept(depths[0]), 0U);
  EXPECT_GT(kept(depths[1]), depths[1].size() / 4);
}

}  // namespace
}  // namespace cousin
