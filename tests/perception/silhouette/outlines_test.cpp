#include "perception/silhouette/outlines.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "perception/silhouette/apparent_contour.h"
#include "perception/silhouette/icosphere.h"
#include "tests/perception/silhouette/board_photograph.h"

namespace cousin {
namespace {

const CastEllipsoid kSeed{{0.0012, -0.0008, 0.002}, {0.0045, 0.003, 0.002}};

SampledSurface sampled(const CastEllipsoid& object) {
  SampledSurface surface;
  surface.mesh = icosphere(5);
  for (Eigen::Vector3d& vertex : surface.mesh.vertices_m) {
    vertex = object.centre_m + object.semi_axes_m.cwiseProduct(vertex);
  }
  surface.normals = vertex_normals(surface.mesh);
  return surface;
}

/// Points of the upper side, as stereo gives them.
void add_cluster(const CastEllipsoid& object, Clusters& clusters) {
  const SampledSurface surface = sampled(object);
  for (std::size_t i = 0; i < surface.mesh.vertices_m.size(); i += 5) {
    if (surface.normals[i].z() < 0.1) continue;
    clusters.cloud.push_back({surface.mesh.vertices_m[i].cast<float>()});
    clusters.instance.push_back(clusters.count);
  }
  ++clusters.count;
}

struct Setting {
  Capture capture;
  Poses poses;
  Clusters clusters;
};

Setting photographed(const std::vector<CastEllipsoid>& objects) {
  Setting setting;
  constexpr double kElevations[] = {0.26, 0.61, 1.05};
  for (int i = 0; i < 6; ++i) {
    const FramePose pose = small_pose(i, 1.1 * i, kElevations[i % 3], 0.36);
    Frame frame;
    frame.id = i;
    frame.sensors.push_back(
        {pose.camera,
         photograph(objects, {}, pose, 0.5, Rng(9).fork(static_cast<std::uint64_t>(i))),
         {},
         {}});
    setting.capture.frames.push_back(std::move(frame));
    setting.poses.push_back(pose);
  }
  for (const CastEllipsoid& object : objects) add_cluster(object, setting.clusters);
  return setting;
}

TEST(Outlines, LieOnTheTrueContour) {
  const Setting setting = photographed({kSeed});
  const Silhouettes silhouettes =
      find_outlines(setting.capture, setting.poses, {}, setting.clusters);
  ASSERT_EQ(silhouettes.size(), setting.poses.size());
  const SampledSurface truth = sampled(kSeed);
  double sum = 0, squares = 0, count = 0, points = 0;
  for (const Silhouette& silhouette : silhouettes) {
    const auto contour = apparent_contour(
        truth, truth.mesh.vertices_m, setting.poses[static_cast<std::size_t>(silhouette.frame)]);
    for (const OutlinePoint& point : silhouette.outline) {
      ++points;
      if (!point.on_object) continue;
      const auto crossing =
          cross_contour(contour, point.pixel_px.cast<double>(), point.normal.cast<double>(), 4);
      ASSERT_TRUE(crossing);
      sum -= crossing->t_px;
      squares += crossing->t_px * crossing->t_px;
      ++count;
    }
  }
  EXPECT_GT(count, 0.8 * points);
  // 0.03 px is 0.01 mm here: a third of the bias allowed for a seed's size, on each of its two
  // sides.
  EXPECT_NEAR(sum / count, 0, 0.03);
  EXPECT_LT(std::sqrt(squares / count), 0.15);
}

TEST(Outlines, PointsNearAnotherSeedAreNotOnTheObject) {
  CastEllipsoid near = kSeed;
  near.centre_m.x() += 2 * kSeed.semi_axes_m.x() + 0.0004;
  const Setting setting = photographed({kSeed, near});
  const Silhouettes silhouettes =
      find_outlines(setting.capture, setting.poses, {}, setting.clusters);
  const SampledSurface other = sampled(near);
  for (const Silhouette& silhouette : silhouettes) {
    if (silhouette.instance != 0) continue;
    const FramePose& pose = setting.poses[static_cast<std::size_t>(silhouette.frame)];
    int cut = 0;
    for (const OutlinePoint& point : silhouette.outline) cut += point.on_object ? 0 : 1;
    EXPECT_GT(cut, 0) << "frame " << silhouette.frame;
    for (const Eigen::Vector3d& vertex : other.mesh.vertices_m) {
      const Eigen::Vector2d pixel = *project(pose.camera, pose.camera_from_world * vertex);
      for (const OutlinePoint& point : silhouette.outline) {
        if (point.on_object) ASSERT_GT((point.pixel_px.cast<double>() - pixel).norm(), 1.0);
      }
    }
  }
}

TEST(Outlines, ViewsWithoutPoseOrObjectHaveNone) {
  Setting setting = photographed({kSeed});
  setting.poses[2].status = PoseStatus::no_board;
  setting.capture.frames[3].sensors.clear();
  for (const Silhouette& silhouette :
       find_outlines(setting.capture, setting.poses, {}, setting.clusters)) {
    EXPECT_NE(silhouette.frame, 2);
    EXPECT_NE(silhouette.frame, 3);
  }
  Clusters far = setting.clusters;
  for (CloudPoint& point : far.cloud) point.position_m.x() += 3;
  EXPECT_TRUE(find_outlines(setting.capture, setting.poses, {}, far).empty());
  EXPECT_TRUE(find_outlines(setting.capture, setting.poses, {}, {}).empty());
  setting.poses.pop_back();
  EXPECT_THROW(find_outlines(setting.capture, setting.poses, {}, setting.clusters),
               std::invalid_argument);
}

TEST(Outlines, SameOnAnyNumberOfThreads) {
  const Setting setting = photographed({kSeed});
  std::vector<Silhouettes> results;
  for (const std::size_t threads : {1, 2, 7}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    results.push_back(find_outlines(setting.capture, setting.poses, {}, setting.clusters));
  }
  for (const Silhouettes& result : results) {
    ASSERT_EQ(result.size(), results[0].size());
    for (std::size_t i = 0; i < result.size(); ++i) {
      ASSERT_EQ(result[i].outline.size(), results[0][i].outline.size());
      for (std::size_t p = 0; p < result[i].outline.size(); ++p) {
        EXPECT_EQ(result[i].outline[p].pixel_px, results[0][i].outline[p].pixel_px);
        EXPECT_EQ(result[i].outline[p].sigma_px, results[0][i].outline[p].sigma_px);
      }
    }
  }
}

TEST(Outlines, BadConfigNamesTheKey) {
  try {
    find_outlines({}, {}, {}, {}, {.margin_px = -1});
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("margin_px"), std::string::npos);
  }
}

}  // namespace
}  // namespace cousin
