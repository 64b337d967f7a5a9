#include "perception/cloud/point_grid.h"

#include <gtest/gtest.h>

#include "sim/types/rng.h"

namespace cousin {
namespace {

std::vector<Eigen::Vector3f> random_points(int count, double side_m, std::uint64_t seed) {
  Rng rng(seed);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < count; ++i) {
    points.emplace_back(static_cast<float>(uniform(rng, 0, side_m)),
                        static_cast<float>(uniform(rng, 0, side_m)),
                        static_cast<float>(uniform(rng, 0, side_m)));
  }
  return points;
}

TEST(PointGrid, FindsExactlyTheNeighboursThatAreNear) {
  const auto points = random_points(400, 0.01, 1);
  const float side = 0.0013F;
  const PointGrid grid(points, side);
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::vector<bool> found(points.size());
    grid.for_neighbours(points[i], [&](std::size_t j) { found[j] = true; });
    for (std::size_t j = 0; j < points.size(); ++j) {
      const float d = (points[i] - points[j]).norm();
      if (std::abs(d - side) > 1e-8F) EXPECT_EQ(found[j], d < side) << i << " " << j;
    }
  }
}

TEST(EuclideanGroups, ChainsLinkAndGapsDoNot) {
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 10; ++i) points.emplace_back(0.001F * static_cast<float>(i), 0.0F, 0.0F);
  points.emplace_back(0.0112F, 0.0F, 0.0F);  // 2.2 mm beyond the chain's end
  const std::vector<int> near = euclidean_groups(points, 0.0011);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(near[static_cast<std::size_t>(i)], 0);
  EXPECT_EQ(near[10], 1);
  for (const int group : euclidean_groups(points, 0.0023)) EXPECT_EQ(group, 0);
}

TEST(EuclideanGroups, NumbersFollowTheFirstPoints) {
  const std::vector<Eigen::Vector3f> points = {
      {5, 0, 0}, {0, 0, 0}, {5.1F, 0, 0}, {9, 0, 0}, {0.1F, 0, 0}};
  EXPECT_EQ(euclidean_groups(points, 0.2), (std::vector<int>{0, 1, 0, 2, 1}));
}

TEST(EuclideanGroups, NoPointsNoGroups) { EXPECT_TRUE(euclidean_groups({}, 0.1).empty()); }

}  // namespace
}  // namespace cousin
