#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "sim/render/leaf_area_truth.h"
#include "sim/render/truth_pass.h"
#include "tests/sim/render/test_scenes.h"

namespace cousin::test {
namespace {

constexpr double kArea_m2 = 0.01;
constexpr int kPoints = 4096;
// A point in each of 4096 strata that a straight edge cuts a hundred or so of: far below this.
constexpr double kTolerance_m2 = 0.01 * kArea_m2;

Material leaf() {
  Material material = matt(0.3F);
  material.kind = SurfaceKind::leaf;
  material.transmittance = {0.2F, 0.2F, 0.2F};
  return material;
}

/// A leaf of 0.1 x 0.1 m in z = 0 with a stem's box, and a card at z = 0.5 that hides, from a
/// camera at (0, 0, 1), the leaf's half of positive x.
Scene leaf_under_a_card() {
  Scene scene;
  ObjectModel plant = square(0.05);
  plant.part_names = {"blade", "stem"};
  const Mesh stem = box({-0.002, -0.002, -0.1}, {0.002, 0.002, -0.01}).mesh;
  const auto n = static_cast<std::uint32_t>(plant.mesh.vertices_m.size());
  plant.triangle_part.assign(plant.mesh.triangles.size(), 0);
  for (const auto& t : stem.triangles) {
    plant.mesh.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
    plant.triangle_part.push_back(1);
  }
  plant.mesh.vertices_m.insert(plant.mesh.vertices_m.end(), stem.vertices_m.begin(),
                               stem.vertices_m.end());
  add(scene, plant, leaf(), {}, true);
  scene.materials.push_back(matt(0.5F));
  scene.instances.back().part_materials = {scene.instances.back().material,
                                           static_cast<int>(scene.materials.size()) - 1};
  Pose aside;
  aside.translation_m = {0.1, 0, 0.5};
  add(scene, square(0.1), matt(0.5F), aside);
  return scene;
}

TrueView view_at(const Eigen::Vector3d& eye_m, const Eigen::Vector3d& target_m = {0, 0, 0}) {
  Camera camera;
  camera.width_px = camera.height_px = 200;
  camera.fx_px = camera.fy_px = 600;
  camera.cx_px = camera.cy_px = 99.5;
  return view_from(camera, eye_m, target_m, Eigen::Vector3d::UnitY());
}

double seen_m2(const LeafAreaView& view) { return seen_area_m2({&view}); }

TEST(LeafAreaTruth, OfALeafHalfUnderACardIsTheOtherHalf) {
  const Scene scene = leaf_under_a_card();
  const RayScene rays(scene);
  const auto areas = view_leaf_areas(rays, scene, view_at({0, 0, 1}), kPoints);
  ASSERT_EQ(areas.size(), 1U);
  EXPECT_NEAR(areas[0].whole_m2, kArea_m2, 1e-15);  // the stem is no leaf
  EXPECT_NEAR(seen_m2(areas[0]), 0.5 * kArea_m2, kTolerance_m2);
}

TEST(LeafAreaTruth, CountsTheLowerSideAndNotWhatTheImageLeavesOut) {
  const Scene scene = leaf_under_a_card();
  const RayScene rays(scene);
  const auto area = [&](const TrueView& view) {
    return seen_m2(view_leaf_areas(rays, scene, view, kPoints)[0]);
  };
  // From below the stem, which is 4 mm square and 10 to 100 mm below the leaf, hides a part of it:
  // its foot at a depth of 0.9 m throws 4 / 0.9 mm onto the leaf.
  const double stem_m2 = std::pow(0.004 / 0.9, 2);
  EXPECT_NEAR(area(view_at({0, 0, -1})), kArea_m2 - stem_m2, kTolerance_m2);
  EXPECT_EQ(area(view_at({0, 0, 1}, {1, 0, 0})), 0);
}

TEST(LeafAreaTruth, OfSeveralViewsIsWhatAnyOfThemSees) {
  const Scene scene = leaf_under_a_card();
  const RayScene rays(scene);
  // From x = 0.1, the card's edge at half the height hides x > -0.1: all of it. From x = -0.05 it
  // hides x > 0.05: nothing.
  const auto hidden = view_leaf_areas(rays, scene, view_at({0.12, 0, 1}), kPoints);
  EXPECT_EQ(seen_m2(hidden[0]), 0);
  const auto half = view_leaf_areas(rays, scene, view_at({0, 0, 1}), kPoints);
  // The edge as seen from (-0.02, 0, 1) falls on x = 0.02.
  const auto more = view_leaf_areas(rays, scene, view_at({-0.02, 0, 1}), kPoints);
  EXPECT_NEAR(seen_area_m2({&hidden[0], &half[0], &more[0]}), 0.7 * kArea_m2, kTolerance_m2);
  EXPECT_EQ(seen_area_m2({}), 0);
}

TEST(LeafAreaTruth, ComesWithTheTruthIfAskedFor) {
  const Scene scene = leaf_under_a_card();
  const RayScene rays(scene);
  EXPECT_TRUE(render_truth(rays, scene, view_at({0, 0, 1}), {.depth = true}).leaf_areas.empty());
  const TruthImages truth = render_truth(rays, scene, view_at({0, 0, 1}), {.leaf_area = true});
  ASSERT_EQ(truth.leaf_areas.size(), 1U);
  // 1024 points: 0.5 / sqrt(1024) = 1.6 % were they not in strata.
  EXPECT_NEAR(seen_m2(truth.leaf_areas[0]), 0.5 * kArea_m2, 0.016 * kArea_m2);
  EXPECT_THROW(view_leaf_areas(rays, scene, view_at({0, 0, 1}), 0), std::invalid_argument);
}

}  // namespace
}  // namespace cousin::test
