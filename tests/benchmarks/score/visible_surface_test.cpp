#include "benchmarks/score/visible_surface.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cousin {
namespace {

/// Two squares of side 2 across the z axis, at z = 0 and z = 1; the second of side `cover`.
Mesh two_squares(double cover) {
  Mesh mesh;
  const auto add = [&](double half, double z) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices_m.size());
    for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
      mesh.vertices_m.emplace_back(half * x, half * y, z);
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back({first, first + 2, first + 3});
  };
  add(1, 0);
  add(0.5 * cover, 1);
  return mesh;
}

SurfaceView from_above(const Eigen::Vector3d& eye_m, double focal_px = 100) {
  const Camera camera{.width_px = 201,
                      .height_px = 201,
                      .fx_px = focal_px,
                      .fy_px = focal_px,
                      .cx_px = 100,
                      .cy_px = 100};
  return {camera, look_at(eye_m, {eye_m.x(), eye_m.y(), 0}, Eigen::Vector3d::UnitY())};
}

TEST(DistanceTree, AWayIsBlockedByWhatLiesAcrossItBetweenItsEnds) {
  const DistanceTree tree(two_squares(1));
  EXPECT_TRUE(tree.blocks({0.1, 0.2, 2}, {0.1, 0.2, 0.5}));
  EXPECT_FALSE(tree.blocks({0.1, 0.2, 2}, {0.1, 0.2, 1.5}));    // ends before
  EXPECT_FALSE(tree.blocks({0.1, 0.2, 0.9}, {0.1, 0.2, 0.1}));  // between the two
  EXPECT_FALSE(tree.blocks({0.6, 0.2, 2}, {0.6, 0.2, 0.5}));    // beside the upper one
  EXPECT_TRUE(tree.blocks({0, 0, 2}, {0, 0, 0.5}));             // through the common edge
  EXPECT_FALSE(tree.blocks({-2, 0, 1}, {2, 0, 1}));             // along its plane
}

TEST(VisibleSurface, ACoverHidesItsShadow) {
  const Mesh mesh = two_squares(1);
  std::vector<Eigen::Vector3d> samples;
  for (int i = 0; i < 41; ++i) samples.emplace_back(-1 + 0.05 * i, 0.013, 0);
  // From (0, 0, 2) the cover of half-width 0.5 at half way hides what is within 1 of the axis.
  const SurfaceView middle = from_above({0, 0, 2});
  const VisibleSamples one = visible_samples(mesh, samples, std::span(&middle, 1), 1);
  for (const Eigen::Vector3d& p : one.seen_m) EXPECT_GE(std::abs(p.x()), 1 - 1e-9);
  EXPECT_GE(one.unseen_m.size(), 39u);
  // From (3, 0, 2) it hides -4 to -2: nothing of these.
  const std::vector<SurfaceView> two = {middle, from_above({3, 0, 2}, 20)};
  EXPECT_EQ(visible_samples(mesh, samples, two, 1).seen_m.size(), 41u);
  // With a longer lens the image ends before it reaches them.
  const SurfaceView narrow = from_above({3, 0, 2}, 110);
  EXPECT_TRUE(visible_samples(mesh, samples, std::span(&narrow, 1), 1).seen_m.empty());
  // At least two views: only where both see it, at most the ends.
  EXPECT_LE(visible_samples(mesh, samples, two, 2).seen_m.size(), 2u);
  EXPECT_TRUE(visible_samples(mesh, samples, {}, 1).seen_m.empty());
}

TEST(VisibleSurface, ASampleIsNotHiddenByItsOwnSurfaceOnEitherSide) {
  const Mesh mesh = two_squares(1);
  const std::vector<Eigen::Vector3d> samples = {{0.9, 0.9, 0}, {0.1, 0.1, 1}};
  const SurfaceView above = from_above({0.2, 0.1, 3});
  EXPECT_EQ(visible_samples(mesh, samples, std::span(&above, 1), 1).seen_m.size(), 2u);
  SurfaceView below = above;
  below.camera_from_world = look_at({0.9, 0.8, -3}, {0.9, 0.8, 0}, Eigen::Vector3d::UnitY());
  const VisibleSamples from_below = visible_samples(mesh, samples, std::span(&below, 1), 1);
  ASSERT_EQ(from_below.seen_m.size(), 1u);
  EXPECT_EQ(from_below.seen_m[0], samples[0]);
}

TEST(VisibleSurface, OnlyWhatCouldBeSeenIsScored) {
  const Mesh mesh = two_squares(1);
  const VisibleSamples samples{.seen_m = {{-0.9, 0, 0}, {-0.7, 0, 0}},
                               .unseen_m = {{0, 0, 0}, {0.9, 0, 0}}};
  const std::vector<double> tolerances = {0.05};
  // Half of the seen surface is measured, 0.03 off; two points lie where nothing was seen, and do
  // not count, though they are far off.
  const std::vector<Eigen::Vector3d> cloud = {{-0.9, 0, 0.03}, {0.1, 0, 0.3}, {0.8, 0, -0.4}};
  const CloudScore score = score_visible_cloud(cloud, mesh, samples, tolerances);
  EXPECT_NEAR(score.accuracy_mean_m, 0.03, 1e-12);
  EXPECT_NEAR(score.completeness_mean_m, 0.5 * (0.03 + std::hypot(0.2, 0.03)), 1e-12);
  EXPECT_NEAR(chamfer_m(score), 0.5 * (score.accuracy_mean_m + score.completeness_mean_m), 1e-15);
  ASSERT_EQ(score.at.size(), 1u);
  EXPECT_EQ(score.at[0].precision, 1);
  EXPECT_EQ(score.at[0].recall, 0.5);
  EXPECT_NEAR(score.at[0].f1, 2.0 / 3, 1e-12);
  EXPECT_THROW(score_visible_cloud(cloud, mesh, {}, tolerances), std::invalid_argument);
}

TEST(VisibleSurface, TheTruthScoresPerfectly) {
  const Mesh mesh = two_squares(1);
  const VisibleSamples samples{.seen_m = sample_surface(mesh, 200, Rng(1)),
                               .unseen_m = sample_surface(mesh, 200, Rng(2))};
  const std::vector<double> tolerances = {1e-9};
  const CloudScore score =
      score_visible_mesh(mesh, sample_surface(mesh, 300, Rng(3)), mesh, samples, tolerances);
  EXPECT_NEAR(chamfer_m(score), 0, 1e-12);
  EXPECT_EQ(score.at[0].f1, 1);
}

TEST(VisibleSurface, RefusesWhatIsNoQuestion) {
  const Mesh mesh = two_squares(1);
  EXPECT_THROW(visible_samples(Mesh{}, {}, {}), std::invalid_argument);
  EXPECT_THROW(visible_samples(mesh, {}, {}, 0), std::invalid_argument);
  EXPECT_THROW(visible_samples(mesh, {}, {}, 1, -1), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
