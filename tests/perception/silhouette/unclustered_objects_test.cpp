#include "perception/silhouette/unclustered_objects.h"

#include <gtest/gtest.h>

#include <cstdint>

#include "tests/perception/silhouette/board_photograph.h"

namespace cousin {
namespace {

const CastEllipsoid kWide{{0.0012, -0.0008, 0.002}, {0.0045, 0.003, 0.002}};
const CastEllipsoid kLeft{{-0.018, 0.006, 0.002}, {0.004, 0.003, 0.002}};
const CastEllipsoid kSlim{{0.010, 0.020, 0.0012}, {0.0035, 0.0014, 0.0012}};
const CastEllipsoid kGrey{{-0.010, -0.020, 0.002}, {0.004, 0.003, 0.002}, {0.4, 0.4, 0.4}};

struct Seen {
  Capture capture;
  Poses poses;
};

Seen photographed(const std::vector<CastEllipsoid>& objects, int views) {
  Seen seen;
  constexpr double kElevations[] = {0.61, 0.8, 1.05};
  for (int i = 0; i < views; ++i) {
    const FramePose pose = small_pose(i, 1.1 * i, kElevations[i % 3], 0.36);
    Frame frame;
    frame.id = i;
    const Rng rng = Rng(9).fork(static_cast<std::uint64_t>(i));
    frame.sensors.push_back({pose.camera, photograph(objects, {}, pose, 0.5, rng), {}, {}});
    seen.capture.frames.push_back(std::move(frame));
    seen.poses.push_back(pose);
  }
  return seen;
}

/// Points over the foot of each object, as stereo gives of its upper side.
Clusters clusters_of(const std::vector<CastEllipsoid>& objects) {
  Clusters clusters;
  for (const CastEllipsoid& object : objects) {
    for (double x = -0.8; x <= 0.8; x += 0.2) {
      const Eigen::Vector3d offset(x * object.semi_axes_m.x(), 0, 0.5 * object.semi_axes_m.z());
      clusters.cloud.push_back({(object.centre_m + offset).cast<float>()});
      clusters.instance.push_back(clusters.count);
    }
    ++clusters.count;
  }
  return clusters;
}

std::vector<UnclusteredObject> lost(const Seen& seen, const Clusters& clusters) {
  return unclustered_objects(seen.capture, seen.poses, {}, clusters, {});
}

TEST(UnclusteredObjects, AreThoseThatPhotographsShowAndNoClusterIsOf) {
  const Seen seen = photographed({kWide, kLeft, kSlim}, 6);
  const auto objects = lost(seen, clusters_of({kWide}));
  ASSERT_EQ(objects.size(), 2U);
  // In the order of rows from -y: the left one stands lower on the plate. A foot is where all rays
  // meet the plate, so its centre is the object's to within a cell or two.
  EXPECT_LT((objects[0].centre_m - kLeft.centre_m.head<2>()).norm(), 0.001);
  EXPECT_LT((objects[1].centre_m - kSlim.centre_m.head<2>()).norm(), 0.001);
  for (const UnclusteredObject& object : objects) {
    EXPECT_EQ(object.views, 6);
    EXPECT_EQ(object.points, 0);
    EXPECT_GT(object.area_m2, 5e-6);
  }
}

TEST(UnclusteredObjects, PointsThatStandOnAFootAreCounted) {
  const Seen seen = photographed({kWide, kLeft}, 6);
  Clusters clusters = clusters_of({kWide, kLeft});
  for (int& instance : clusters.instance) instance = instance == 1 ? -1 : instance;
  const auto objects = lost(seen, clusters);
  ASSERT_EQ(objects.size(), 1U);
  EXPECT_GE(objects[0].points, 5);  // of nine along the long axis: a foot ends before the flanks do
}

TEST(UnclusteredObjects, AreNoneWhereAllAreClusteredOrNothingStands) {
  const std::vector<CastEllipsoid> all = {kWide, kLeft, kSlim};
  for (const int views : {1, 3, 6}) {
    EXPECT_TRUE(lost(photographed(all, views), clusters_of(all)).empty()) << views << " views";
    EXPECT_TRUE(lost(photographed({}, views), {}).empty()) << views << " views of a bare board";
  }
}

TEST(UnclusteredObjects, GreyThingsAndViewsWithoutAPoseSayNothing) {
  EXPECT_TRUE(lost(photographed({kGrey}, 6), {}).empty());
  Seen seen = photographed({kWide}, 3);
  for (FramePose& pose : seen.poses) pose.status = PoseStatus::no_board;
  EXPECT_TRUE(lost(seen, {}).empty());
  EXPECT_TRUE(unclustered_objects({}, {}, {}, {}, {}).empty());
}

TEST(UnclusteredObjects, LampsThatTintThePaperAreBalanced) {
  Seen seen = photographed({kWide}, 6);
  for (Frame& frame : seen.capture.frames) {
    for (Rgb8& pixel : frame.sensors[0].color) {
      pixel.g = static_cast<std::uint8_t>(pixel.g * 0.85);
      pixel.b = static_cast<std::uint8_t>(pixel.b * 0.6);  // paper of a saturation of 0.4
    }
  }
  EXPECT_EQ(lost(seen, {}).size(), 1U);
  EXPECT_TRUE(lost(seen, clusters_of({kWide})).empty());
}

}  // namespace
}  // namespace cousin
