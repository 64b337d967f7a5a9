#include "perception/splats/splat_geometry.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>

#include "perception/splats/depth_mesh.h"
#include "sim/geometry/measure.h"
#include "tests/perception/splats/sphere_splats.h"

namespace cousin {
namespace {

constexpr double kPi = std::numbers::pi;

/// Exact depth of a ball from a viewpoint; NaN beside it.
Image<float> ball_depth(const SplatViewpoint& from, const Eigen::Vector3d& centre_m,
                        double radius_m) {
  const Eigen::Vector3d c = from.camera_from_world * centre_m;
  Image<float> depth_m(from.camera.width_px, from.camera.height_px,
                       std::numeric_limits<float>::quiet_NaN());
  for (int y = 0; y < depth_m.height(); ++y) {
    for (int x = 0; x < depth_m.width(); ++x) {
      const Eigen::Vector3d ray((x - from.camera.cx_px) / from.camera.fx_px,
                                (y - from.camera.cy_px) / from.camera.fy_px, 1);
      const double b = ray.dot(c), a = ray.squaredNorm();
      const double root = b * b - a * (c.squaredNorm() - radius_m * radius_m);
      if (root >= 0) depth_m(x, y) = static_cast<float>((b - std::sqrt(root)) / a);
    }
  }
  return depth_m;
}

SplatDepthImages ball_depths(const SphereSplats& sphere) {
  SplatDepthImages result;
  for (const SplatViewpoint& from : sphere.viewpoints()) {
    const int id = static_cast<int>(result.poses.size());
    FramePose pose;
    pose.frame = id;
    pose.status = PoseStatus::ok;
    pose.camera_from_world = from.camera_from_world;
    pose.camera = from.camera;
    result.poses.push_back(pose);
    result.depths.push_back({id, ball_depth(from, sphere.centre_m, sphere.radius_m), {}});
  }
  return result;
}

DepthMeshConfig around(const SphereSplats& sphere) {
  return {.low_m = sphere.centre_m - Eigen::Vector3d::Constant(0.12),
          .high_m = sphere.centre_m + Eigen::Vector3d::Constant(0.12),
          .step_m = 0.004,
          .truncation_m = 0.012};
}

TEST(DepthMesh, ExactDepthsOfABallGiveTheBall) {
  const SphereSplats sphere;
  const SplatDepthImages depths = ball_depths(sphere);
  const Mesh mesh = mesh_of_depths(depths.poses, depths.depths, around(sphere));
  const MeshCheck check = check_watertight(mesh);
  EXPECT_TRUE(check.ok) << check.problem;
  double worst_m = 0, sum_m = 0;
  for (const Eigen::Vector3d& v : mesh.vertices_m) {
    const double off_m = (v - sphere.centre_m).norm() - sphere.radius_m;
    worst_m = std::max(worst_m, std::abs(off_m));
    sum_m += off_m;
  }
  // Distances along rays are longer than across the surface where it is seen aslant, and views
  // that see an edge see through what lies within the truncation beyond it: below a step (.62).
  EXPECT_LT(worst_m, 0.004);
  EXPECT_LT(std::abs(sum_m / static_cast<double>(mesh.vertices_m.size())), 0.125 * 0.004);
  const double volume = 4.0 / 3 * kPi * std::pow(sphere.radius_m, 3);
  EXPECT_NEAR(mass_properties(mesh).volume_m3, volume, 0.02 * volume);
}

TEST(DepthMesh, WhatIsHiddenFromAllViewsIsInsideAndTheBoxCloses) {
  // A wall seen from one side only: all behind it, as far as the box goes, is inside.
  SplatDepthImages depths;
  const Camera camera{
      .width_px = 200, .height_px = 200, .fx_px = 200, .fy_px = 200, .cx_px = 99.5, .cy_px = 99.5};
  for (int i = 0; i < 2; ++i) {
    FramePose pose;
    pose.status = PoseStatus::ok;
    pose.camera = camera;
    pose.camera_from_world.translation_m = {0.01 * i, 0, 0};
    depths.poses.push_back(pose);
    depths.depths.push_back({i, Image<float>(200, 200, 1.0f), {}});
  }
  const DepthMeshConfig config{
      .low_m = {-0.1, -0.1, 0.9}, .high_m = {0.1, 0.1, 1.1}, .step_m = 0.01, .truncation_m = 0.03};
  const Mesh mesh = mesh_of_depths(depths.poses, depths.depths, config);
  EXPECT_TRUE(check_watertight(mesh).ok);
  // 0.2 x 0.2 x 0.1 m; the box's sides close within a step, at a share of it that the values there
  // set.
  const double low = 0.20 * 0.20 * 0.10, high = 0.22 * 0.22 * 0.11;
  EXPECT_GT(mass_properties(mesh).volume_m3, low);
  EXPECT_LT(mass_properties(mesh).volume_m3, high);
}

TEST(DepthMesh, OneViewThatSeesThroughCarvesNothing) {
  const SphereSplats sphere;
  SplatDepthImages depths = ball_depths(sphere);
  const auto volume = [&](int free_views) {
    DepthMeshConfig config = around(sphere);
    config.free_views = free_views;
    return mass_properties(mesh_of_depths(depths.poses, depths.depths, config)).volume_m3;
  };
  const double before = volume(2);
  for (float& depth : depths.depths[3].depth_m) depth = std::numeric_limits<float>::quiet_NaN();
  // One of sixteen views no longer adds its distances.
  EXPECT_NEAR(volume(2), before, 0.02 * before);
  // If one view were enough, the inside would go, and a shell of the truncation's width be left.
  EXPECT_LT(volume(1), 0.5 * before);
}

TEST(DepthMesh, WithoutDepthThereIsNoMesh) {
  EXPECT_TRUE(mesh_of_depths({}, {}).triangles.empty());
  const SphereSplats sphere;
  SplatDepthImages depths = ball_depths(sphere);
  for (FramePose& pose : depths.poses) pose.status = PoseStatus::no_board;
  EXPECT_TRUE(mesh_of_depths(depths.poses, depths.depths, around(sphere)).triangles.empty());
}

TEST(DepthMesh, RefusesWhatDoesNotFit) {
  SplatDepthImages depths = ball_depths(SphereSplats{});
  EXPECT_THROW(mesh_of_depths({}, depths.depths), std::invalid_argument);
  depths.depths[1].depth_m = Image<float>(10, 10);
  EXPECT_THROW(mesh_of_depths(depths.poses, depths.depths), std::invalid_argument);
  EXPECT_THROW(mesh_of_depths({}, {}, {.step_m = 0}), std::invalid_argument);
  EXPECT_THROW(mesh_of_depths({}, {}, {.step_m = 1e-5}), std::invalid_argument);
  EXPECT_THROW(mesh_of_depths({}, {}, {.low_m = {1, 1, 1}}), std::invalid_argument);
  EXPECT_THROW(mesh_of_depths({}, {}, {.truncation_m = 1e-4}), std::invalid_argument);
}

TEST(SplatGeometry, CentresAreThePapersCloud) {
  SphereSplats sphere{.count = 100};
  SplatModel model = sphere.model();
  model.splats[7].opacity_logit = -0.01f;  // just below one half
  model.splats[8].opacity_logit = 0.01f;
  const Cloud cloud = splat_centres(model);
  ASSERT_EQ(cloud.size(), 99u);
  for (const CloudPoint& point : cloud) {
    // Floats resolve 1e-8 of 0.1 m.
    EXPECT_NEAR((point.position_m.cast<double>() - sphere.centre_m).norm(), 0.1, 1e-7);
    // 0.5 + 0.2821 (1, 0, -1), times 255.
    EXPECT_EQ(point.color, (Rgb8{199, 128, 56}));
  }
  EXPECT_EQ(splat_centres(model, 0).size(), 100u);
  EXPECT_EQ(splat_centres(model, 1).size(), 0u);
  EXPECT_THROW(splat_centres(model, 1.5), std::invalid_argument);
  model.origin_in_world_m = {0, 1000, 0};  // floats there are 0.06 mm apart
  EXPECT_EQ(splat_centres(model).size(), 99u);
  model.origin_in_world_m = {0, 1e6, 0};
  EXPECT_THROW(splat_centres(model), std::invalid_argument);
  EXPECT_EQ(splat_centres(model, 1).size(), 0u);
  model.splats = {model.splats[0], model.splats[0]};  // nothing apart that could fall together
  EXPECT_EQ(splat_centres(model).size(), 2u);
  model.origin_in_world_m.x() = std::nan("");
  EXPECT_THROW(splat_centres(model), std::invalid_argument);
}

TEST(SplatGeometry, SplatsOnABallGiveItsCloudMeshAndWhoSeesThem) {
  const SphereSplats sphere;
  const SplatModel model = sphere.model();
  const std::vector<SplatViewpoint> from = sphere.viewpoints();
  const SplatDepthImages depths = render_splat_depths(model, from);

  const Cloud cloud =
      fused_splat_cloud(depths, {.voxel_m = 0.002, .agreement_m = 0.004, .min_views = 2});
  ASSERT_GT(cloud.size(), 5000u);
  std::vector<double> off_m;
  double facing = 0;
  for (const CloudPoint& point : cloud) {
    const Eigen::Vector3d out = point.position_m.cast<double>() - sphere.centre_m;
    off_m.push_back(std::abs(out.norm() - sphere.radius_m));
    facing += point.normal.cast<double>().dot(out.normalized()) / static_cast<double>(cloud.size());
  }
  std::sort(off_m.begin(), off_m.end());
  // A pixel has the depth of a Gaussian whose centre is about a scale, 1.5 mm, to its side.
  EXPECT_LT(off_m[off_m.size() / 2], sphere.scale_m);
  EXPECT_LT(off_m[off_m.size() * 95 / 100], 2 * sphere.scale_m);
  EXPECT_GT(facing, 0.95);

  const Mesh mesh = mesh_of_depths(depths.poses, depths.depths, around(sphere));
  EXPECT_TRUE(check_watertight(mesh).ok);
  const double volume = 4.0 / 3 * kPi * std::pow(sphere.radius_m, 3);
  EXPECT_NEAR(mass_properties(mesh).volume_m3, volume, 0.05 * volume);

  // A camera at distance d sees a Gaussian whose direction is within acos(r / d) of its own. Where
  // it looks aslant, neighbours within a pixel or two are at other depths: 2 mm a pixel, 60
  // degrees.
  const std::vector<int> counts = views_that_see(model, depths, 5);
  const double limit = sphere.radius_m / 0.5;
  for (int i = 0; i < sphere.count; i += 37) {
    int surely = 0, at_most = 0;
    for (const SplatViewpoint& view : from) {
      const double cosine = sphere.direction(i).dot(
          (centre_in_world_m(view.camera_from_world) - sphere.centre_m).normalized());
      surely += cosine > 0.5 ? 1 : 0;
      at_most += cosine > limit - 0.15 ? 1 : 0;
    }
    EXPECT_GE(counts[static_cast<std::size_t>(i)], surely) << i;
    EXPECT_LE(counts[static_cast<std::size_t>(i)], at_most) << i;
  }
}

TEST(SplatGeometry, AnyNumberOfThreadsGivesTheSameBytes) {
  const SphereSplats sphere{.count = 3000, .scale_m = 0.004};
  const SplatModel model = sphere.model();
  const std::vector<SplatViewpoint> from = sphere.viewpoints(5);
  const auto with_threads = [&](int threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(threads));
    tbb::task_arena arena(threads);
    return arena.execute([&] {
      const SplatDepthImages depths = render_splat_depths(model, from);
      return std::pair(mesh_of_depths(depths.poses, depths.depths, around(sphere)),
                       views_that_see(model, depths));
    });
  };
  const auto one = with_threads(1);
  const auto eight = with_threads(8);
  EXPECT_EQ(one.first.vertices_m, eight.first.vertices_m);
  EXPECT_EQ(one.first.triangles, eight.first.triangles);
  EXPECT_EQ(one.second, eight.second);
}

TEST(SplatGeometry, AnEmptyModelIsSeenByNoneAndHasNoMesh) {
  const SphereSplats sphere;
  const SplatDepthImages depths = render_splat_depths(SplatModel{}, sphere.viewpoints(3));
  EXPECT_TRUE(views_that_see(SplatModel{}, depths).empty());
  EXPECT_TRUE(fused_splat_cloud(depths).empty());
  EXPECT_TRUE(mesh_of_depths(depths.poses, depths.depths, around(sphere)).triangles.empty());
  EXPECT_THROW(views_that_see(SplatModel{}, depths, -1), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
