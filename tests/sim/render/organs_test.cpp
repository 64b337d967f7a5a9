#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "sim/render/leaf_area_truth.h"
#include "sim/render/truth_pass.h"
#include "sim/render/view_match.h"
#include "tests/sim/render/test_scenes.h"

namespace cousin::test {
namespace {

/// A specimen of two squares of 0.1 m beside each other in z = 0, of which a post hides some, and
/// another specimen behind.
struct TwoLeaves {
  Scene scene;
  int plant = 0;  ///< id

  explicit TwoLeaves(bool is_split) {
    ObjectModel model = square(0.05);
    for (Eigen::Vector3d& v : model.mesh.vertices_m) v.x() -= 0.05;
    const auto n = static_cast<std::uint32_t>(model.mesh.vertices_m.size());
    ObjectModel right = square(0.05);
    for (Eigen::Vector3d& v : right.mesh.vertices_m) v.x() += 0.05;
    model.part_names = right.part_names = {"left", "right"};
    model.keypoints = {{"left", {-0.05, 0, 0}}, {"right", {0.05, 0, 0}}, {"tip", {0.1, 0.02, 0}}};
    model.triangle_part.assign(model.mesh.triangles.size(), 0);
    right.triangle_part.assign(right.mesh.triangles.size(), 1);
    Material leaf = matt(0.3F);
    leaf.kind = SurfaceKind::leaf;
    leaf.transmittance = {0.2F, 0.2F, 0.2F};
    if (is_split) {
      plant = add(scene, model, leaf, {}, true);
      const int organ = add(scene, right, leaf);
      scene.instances.back().part_of = plant;
      scene.instances.front().keypoint_carriers = {plant, organ, organ};
    } else {
      for (const auto& t : right.mesh.triangles)
        model.mesh.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
      model.mesh.vertices_m.insert(model.mesh.vertices_m.end(), right.mesh.vertices_m.begin(),
                                   right.mesh.vertices_m.end());
      model.triangle_part.insert(model.triangle_part.end(), right.triangle_part.begin(),
                                 right.triangle_part.end());
      plant = add(scene, model, leaf, {}, true);
      add(scene, square(0.001), matt(0.5F), Pose{Eigen::Quaterniond::Identity(), {9, 9, -9}});
    }
    add(scene, box({-0.003, -0.2, 0.1}, {0.012, 0.03, 0.11}), matt(0.5F));
    add(scene, box({0.02, -0.2, -0.3}, {0.15, 0.2, -0.2}), matt(0.5F), {}, true);
  }
};

TrueView from_above() {
  Camera camera;
  camera.width_px = camera.height_px = 160;
  camera.fx_px = camera.fy_px = 400;
  camera.cx_px = camera.cy_px = 79.5;
  return view_from(camera, {0, 0, 0.8}, {0, 0, 0}, Eigen::Vector3d::UnitY());
}

TEST(Organs, CountAsTheirSpecimenInAllTruth) {
  const TwoLeaves one(false), apart(true);
  const TruthNeeds needs = {.instance = true,
                            .part = true,
                            .coverage = true,
                            .visibility = true,
                            .shares = true,
                            .keypoints = true,
                            .leaf_area = true};
  const TruthImages a = render_truth(RayScene(one.scene), one.scene, from_above(), needs);
  const TruthImages b = render_truth(RayScene(apart.scene), apart.scene, from_above(), needs);
  EXPECT_EQ(a.instance, b.instance);
  EXPECT_EQ(a.part, b.part);
  EXPECT_EQ(a.specimen_coverage, b.specimen_coverage);
  EXPECT_EQ(a.masks_full, b.masks_full);
  ASSERT_EQ(a.visibility.size(), 2U);
  ASSERT_EQ(b.visibility.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(a.visibility[i].instance, b.visibility[i].instance);
    EXPECT_EQ(a.visibility[i].pixels_full, b.visibility[i].pixels_full);
    EXPECT_EQ(a.visibility[i].pixels_visible, b.visibility[i].pixels_visible);
    EXPECT_EQ(a.visibility[i].seen_width, b.visibility[i].seen_width);
    ASSERT_EQ(a.shares.size(), b.shares.size());
    EXPECT_EQ(a.shares[i].pixels, b.shares[i].pixels);
  }
  EXPECT_LT(b.visibility[0].visible_fraction, 1);  // the post hides some
  EXPECT_GT(b.visibility[0].box_width, 90);        // both leaves, 100 px wide together
  ASSERT_EQ(b.keypoints.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(a.keypoints[i].instance, b.keypoints[i].instance);
    EXPECT_EQ(a.keypoints[i].state, b.keypoints[i].state);
    EXPECT_EQ(a.keypoints[i].pixel_px, b.keypoints[i].pixel_px);
  }
  ASSERT_EQ(b.leaf_areas.size(), 2U);
  EXPECT_NEAR(b.leaf_areas[0].whole_m2, 0.02, 1e-12);
  EXPECT_EQ(a.leaf_areas[0].is_seen, b.leaf_areas[0].is_seen);
}

TEST(Organs, CarryTheirKeypointsAndTheirFlow) {
  TwoLeaves apart(true);
  Pose moved;
  moved.translation_m = {0.02, 0, 0};
  apart.scene.instances[1].motion = {{0, {}}, {1, moved}};
  const RayScene before(apart.scene, 0), after(apart.scene, 1);
  TrueView here = from_above(), there = here;
  there.time_s = 1;
  const TruthNeeds needs = {.depth = true, .instance = true, .keypoints = true};
  const TruthImages a = render_truth(before, apart.scene, here, needs);
  const TruthImages b = render_truth(after, apart.scene, there, needs);
  // 20 mm at 0.8 m and f = 400 px.
  const Eigen::Vector2d step_px(10, 0);
  EXPECT_EQ(a.keypoints[0].pixel_px, b.keypoints[0].pixel_px);
  EXPECT_NEAR((b.keypoints[1].pixel_px - a.keypoints[1].pixel_px - step_px).norm(), 0, 1e-9);
  const ViewMatch match =
      match_views(apart.scene, {before, here}, a.depth_m, a.instance, {after, there});
  ASSERT_EQ(a.instance(50, 60), apart.plant);
  ASSERT_EQ(a.instance(120, 60), apart.plant);
  EXPECT_NEAR(static_cast<double>(match.flow_px(50, 60).norm()), 0, 1e-4);
  EXPECT_NEAR(static_cast<double>((match.flow_px(120, 60) - step_px.cast<float>()).norm()), 0,
              1e-4);
}

}  // namespace
}  // namespace cousin::test
