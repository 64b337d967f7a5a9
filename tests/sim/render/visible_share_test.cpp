#include "sim/render/visible_share.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "sim/geometry/cube_sphere.h"

namespace cousin {
namespace {

/// A ball of 40 mm at the origin, and a sheet of 20 by 20 cm that can stand before it.
Scene ball_and_sheet(const Eigen::Vector3d& sheet_m) {
  Scene scene;
  scene.name = "ball";
  scene.materials.resize(1);
  scene.models.resize(2);
  scene.models[0].mesh = cube_sphere(40);
  for (Eigen::Vector3d& p : scene.models[0].mesh.vertices_m) p *= 0.04;
  scene.models[1].mesh.vertices_m = {
      {0, -0.1, -0.1}, {0, 0.1, -0.1}, {0, 0.1, 0.1}, {0, -0.1, 0.1}};
  scene.models[1].mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  for (int i = 0; i < 2; ++i) {
    Instance instance;
    instance.id = 5 + i;
    instance.model = i;
    scene.instances.push_back(instance);
  }
  scene.instances[1].world_from_object.translation_m = sheet_m;
  return scene;
}

TrueView from_front(double distance_m) {
  Camera camera{.width_px = 640,
                .height_px = 480,
                .fx_px = 390,
                .fy_px = 390,
                .cx_px = 319.5,
                .cy_px = 239.5};
  return view_about(camera, look_at({distance_m, 0, 0}, Eigen::Vector3d::Zero()),
                    Eigen::Vector3d::Zero(), 0.04, 200);
}

TEST(VisibleShare, IsAHalfBehindASheetWhoseEdgeCrossesTheMiddle) {
  const Scene scene = ball_and_sheet({0.06, 0.1, 0});
  const VisibleShare visible(scene, 0, 1);
  // 200 pixels across: one column is 0.6 % of a disk at its middle.
  EXPECT_NEAR(visible.seen(from_front(0.5)), 0.5, 0.007);
}

TEST(VisibleShare, MovedThingsHideWhereTheyWereMovedTo) {
  const Scene scene = ball_and_sheet({0.06, 0.3, 0});
  const VisibleShare visible(scene, 0, 1, {1});
  EXPECT_EQ(visible.seen(from_front(0.5)), 1);
  Pose pose;
  pose.translation_m = {0.06, 0.1, 0};
  EXPECT_NEAR(visible.seen(from_front(0.5), {{1, pose}}), 0.5, 0.007);
  pose.translation_m.x() = -0.06;  // behind the ball
  EXPECT_EQ(visible.seen(from_front(0.5), {{1, pose}}), 1);
  EXPECT_THROW(visible.seen(from_front(0.5), {{0, pose}}), std::invalid_argument);
}

TEST(VisibleShare, WhatIsOutOfReachIsLeftOut) {
  const Scene scene = ball_and_sheet({0.4, 0.1, 0});
  EXPECT_EQ(VisibleShare(scene, 0, 0.2).seen(from_front(0.5)), 1);
  EXPECT_LT(VisibleShare(scene, 0, 0.5).seen(from_front(0.5)), 0.6);
}

TEST(ViewAbout, ACameraInsideTheBallOrLookingAwayIsRefused) {
  EXPECT_THROW(from_front(0.03), std::invalid_argument);
  const Camera camera{
      .width_px = 64, .height_px = 48, .fx_px = 60, .fy_px = 60, .cx_px = 31.5, .cy_px = 23.5};
  EXPECT_THROW(view_about(camera, look_at({1, 0, 0}, {2, 0, 0}), Eigen::Vector3d::Zero(), 0.04, 50),
               std::invalid_argument);
}

TEST(ViewAbout, WhereTheBallFillsTheImageTheImagesPartCounts) {
  const Scene scene = ball_and_sheet({0.06, 0.3, 0});
  const VisibleShare visible(scene, 0, 1);
  const TrueView near = from_front(0.045);  // the ball is wider than the image
  EXPECT_LE(near.camera.height_px, near.camera.width_px);
  EXPECT_EQ(visible.seen(near), 1);
}

}  // namespace
}  // namespace cousin
