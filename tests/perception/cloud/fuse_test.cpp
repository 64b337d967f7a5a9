#include "perception/cloud/fuse.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "sim/types/rng.h"
#include "tests/perception/mvs/synthetic_seeds.h"

namespace cousin {
namespace {

constexpr double kNoiseM = 0.0001;
const SyntheticSeed kSeed{0.001, -0.002, {0.007, 0.006, 0.004}, 0.4};

/// Six views of an ellipsoid with its true depths plus independent noise.
struct NoisyViews {
  SyntheticViews views;
  Depths depths;
};
NoisyViews noisy_views() {
  SyntheticScene scene;
  scene.seeds = {kSeed};
  scene.board.plate_m = 0.030;
  scene.board.squares = 4;
  scene.board.has_markers = false;
  scene.supersampling = 1;
  std::vector<Eigen::Vector3d> eyes;
  for (int i = 0; i < 6; ++i)
    eyes.emplace_back(0.1 * std::cos(i * 1.047), 0.1 * std::sin(i * 1.047), 0.3);
  NoisyViews result{make_views(scene, synthetic_camera(LensModel::opencv5, 160, 120, 800), eyes, 5),
                    {}};
  Rng rng(2);
  for (std::size_t i = 0; i < result.views.depth_m.size(); ++i) {
    Image<float> depth = result.views.depth_m[i];
    for (float& z : depth) z += static_cast<float>(kNoiseM * normal(rng));
    Image<float> sigma(160, 120, static_cast<float>(kNoiseM));
    result.depths.push_back({static_cast<int>(i), std::move(depth), std::move(sigma)});
  }
  return result;
}

/// Signed distance to the seed's surface, first order.
double off_seed_m(const Eigen::Vector3d& p) {
  const Eigen::Vector3d o = p - kSeed.centre_in_world_m();
  const double c = std::cos(kSeed.yaw_rad), s = std::sin(kSeed.yaw_rad);
  const Eigen::Vector3d q(c * o.x() + s * o.y(), -s * o.x() + c * o.y(), o.z());
  const double f = q.cwiseQuotient(kSeed.radii_m).norm();
  return (f - 1) * f / q.cwiseQuotient(kSeed.radii_m.cwiseAbs2()).norm();
}

TEST(Fuse, AveragesTheViewsNoiseAndSaysSo) {
  const NoisyViews noisy = noisy_views();
  const Cloud cloud = fuse_depths(noisy.views.capture, noisy.views.poses, noisy.depths, {});
  double squares = 0, scaled = 0;
  int n = 0;
  for (const CloudPoint& p : cloud) {
    if (p.position_m.z() < 0.004F) continue;  // the upper half, away from the rim
    const double off = off_seed_m(p.position_m.cast<double>());
    squares += off * off;
    scaled += off * off / (p.sigma_m * p.sigma_m);
    ++n;
  }
  ASSERT_GT(n, 300);
  // Six views of 0.1 mm give 0.04 mm; points at pixel corners and slopes add some.
  EXPECT_LT(std::sqrt(squares / n), 0.00007);
  // Predicted and real spread agree to a third.
  EXPECT_NEAR(std::sqrt(scaled / n), 1, 0.35);
}

TEST(Fuse, NormalsPointOutOfTheSurface) {
  const NoisyViews noisy = noisy_views();
  std::vector<double> cosines;
  for (const CloudPoint& p :
       fuse_depths(noisy.views.capture, noisy.views.poses, noisy.depths, {})) {
    if (p.position_m.z() < 0.005F) continue;
    EXPECT_NEAR(p.normal.norm(), 1, 1e-4);
    cosines.push_back(
        outward_normal(kSeed, p.position_m.cast<double>()).dot(p.normal.cast<double>()));
  }
  std::nth_element(cosines.begin(),
                   cosines.begin() + static_cast<std::ptrdiff_t>(cosines.size() / 2),
                   cosines.end());
  EXPECT_GT(cosines[cosines.size() / 2],
            0.985);  // 0.1 mm over windows of 1.5 mm: ten degrees at the median
}

TEST(Fuse, NormalsOfTheDepthsAreTakenWhereThereAreAny) {
  NoisyViews noisy = noisy_views();
  const Cloud without = fuse_depths(noisy.views.capture, noisy.views.poses, noisy.depths, {});
  for (std::size_t i = 0; i < noisy.depths.size(); ++i) {
    FrameDepth& depth = noisy.depths[i];
    const Pose& pose = noisy.views.poses[i].camera_from_world;
    depth.normal = Image<Eigen::Vector3f>(160, 120, Eigen::Vector3f::Zero());
    for (int y = 0; y < 120; ++y) {
      for (int x = 0; x < 160; ++x) {
        if (noisy.views.object[i](x, y) != 0) continue;
        const Eigen::Vector3d ray = *unproject(noisy.views.poses[i].camera, Eigen::Vector2d(x, y));
        const Eigen::Vector3d in_world_m =
            inverse(pose) * (ray * (noisy.views.depth_m[i](x, y) / ray.z())).eval();
        depth.normal(x, y) = (pose.rotation * outward_normal(kSeed, in_world_m)).cast<float>();
      }
    }
  }
  const auto worst_on_top = [](const Cloud& cloud) {
    double worst = 1;
    for (const CloudPoint& p : cloud) {
      if (p.position_m.z() < 0.007F) continue;
      worst = std::min(
          worst, outward_normal(kSeed, p.position_m.cast<double>()).dot(p.normal.cast<double>()));
    }
    return worst;
  };
  const Cloud cloud = fuse_depths(noisy.views.capture, noisy.views.poses, noisy.depths, {});
  ASSERT_GT(cloud.size(), 300U);
  // Six degrees: with noise of 0.1 mm planes are 8 off, the true normals within a voxel 2.
  EXPECT_LT(worst_on_top(without), 0.995);
  EXPECT_GT(worst_on_top(cloud), 0.995);

  // What does not face the camera or is no number is not taken.
  for (FrameDepth& depth : noisy.depths) {
    for (Eigen::Vector3f& normal : depth.normal)
      normal = normal.x() > 0 ? Eigen::Vector3f(-normal) : Eigen::Vector3f::Constant(NAN);
  }
  const Cloud wrong = fuse_depths(noisy.views.capture, noisy.views.poses, noisy.depths, {});
  ASSERT_EQ(wrong.size(), without.size());
  for (std::size_t i = 0; i < wrong.size(); ++i) {
    ASSERT_EQ(wrong[i].position_m, without[i].position_m);
    ASSERT_EQ(wrong[i].normal, without[i].normal);
  }

  noisy.depths[2].normal = Image<Eigen::Vector3f>(160, 119, Eigen::Vector3f::Zero());
  EXPECT_THROW(fuse_depths(noisy.views.capture, noisy.views.poses, noisy.depths, {}),
               std::invalid_argument);
}

TEST(Fuse, GreenIsLeftOut) {
  NoisyViews noisy = noisy_views();
  for (Frame& frame : noisy.views.capture.frames)
    frame.sensors[0].color = Image<Rgb8>(160, 120, {40, 180, 60});
  EXPECT_TRUE(fuse_depths(noisy.views.capture, noisy.views.poses, noisy.depths, {}).empty());
}

TEST(Fuse, WhatOneViewSeesAloneIsLeftOut) {
  NoisyViews noisy = noisy_views();
  for (std::size_t i = 1; i < noisy.depths.size(); ++i) noisy.depths[i].depth_m = {};
  EXPECT_TRUE(fuse_depths(noisy.views.capture, noisy.views.poses, noisy.depths, {}).empty());
  EXPECT_FALSE(
      fuse_depths(noisy.views.capture, noisy.views.poses, noisy.depths, {}, {.min_views = 1})
          .empty());
}

TEST(Fuse, DepthsThatDisagreeMakeNoPoints) {
  NoisyViews noisy = noisy_views();
  for (std::size_t i = 0; i < noisy.depths.size(); ++i) {
    for (float& z : noisy.depths[i].depth_m) z += 0.002F * static_cast<float>(i);  // 2 mm apart
  }
  const std::size_t agreed =
      fuse_depths(noisy.views.capture, noisy.views.poses, noisy_views().depths, {}).size();
  const std::size_t apart =
      fuse_depths(noisy.views.capture, noisy.views.poses, noisy.depths, {}).size();
  EXPECT_LT(static_cast<double>(apart), 0.1 * static_cast<double>(agreed));
}

TEST(Fuse, SameBytesOnAnyNumberOfThreads) {
  const NoisyViews noisy = noisy_views();
  const auto run = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return fuse_depths(noisy.views.capture, noisy.views.poses, noisy.depths, {});
  };
  const Cloud one = run(1);
  for (const std::size_t threads : {2U, 7U}) {
    const Cloud other = run(threads);
    ASSERT_EQ(one.size(), other.size());
    for (std::size_t i = 0; i < one.size(); ++i) {
      EXPECT_EQ(one[i].position_m, other[i].position_m);
      EXPECT_EQ(one[i].normal, other[i].normal);
      EXPECT_EQ(one[i].color, other[i].color);
      EXPECT_EQ(one[i].sigma_m, other[i].sigma_m);
    }
  }
}

TEST(Fuse, FarFromTheOriginIsRefusedAndFarPointsAreLeftOut) {
  NoisyViews noisy = noisy_views();
  const std::size_t points =
      fuse_depths(noisy.views.capture, noisy.views.poses, noisy.depths, {}).size();
  noisy.depths[0].depth_m(80, 60) = 1e30F;  // 315 m by default is the farthest
  EXPECT_NEAR(static_cast<double>(
                  fuse_depths(noisy.views.capture, noisy.views.poses, noisy.depths, {}).size()),
              static_cast<double>(points), 10);
  const Eigen::Vector3d offset_m(0, 400, 0);
  for (FramePose& pose : noisy.views.poses)
    pose.camera_from_world.translation_m -= pose.camera_from_world.rotation * offset_m;
  try {
    (void)fuse_depths(noisy.views.capture, noisy.views.poses, noisy.depths, {});
    FAIL() << "400 m";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("frame 0 is 400"), std::string::npos) << error.what();
  }
}

TEST(Fuse, EmptyAndMismatchedInput) {
  EXPECT_TRUE(fuse_depths({}, {}, {}, {}).empty());
  NoisyViews noisy = noisy_views();
  noisy.depths[2].depth_m = Image<float>(10, 10, 0.3F);
  EXPECT_THROW(fuse_depths(noisy.views.capture, noisy.views.poses, noisy.depths, {}),
               std::invalid_argument);
  noisy.depths.pop_back();
  EXPECT_THROW(fuse_depths(noisy.views.capture, noisy.views.poses, noisy.depths, {}),
               std::invalid_argument);
}

}  // namespace
}  // namespace cousin
