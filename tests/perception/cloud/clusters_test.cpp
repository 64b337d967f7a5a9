#include "perception/cloud/clusters.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "sim/types/not_built.h"

namespace cousin {
namespace {

constexpr Rgb8 kSeedColor{200, 160, 90};

/// Upper half of an ellipsoid that lies on the board, evenly covered.
void add_seed(Cloud& cloud, double x_m, double y_m, const Eigen::Vector3d& radii_m,
              Rgb8 color = kSeedColor) {
  constexpr int kPoints = 1500;
  for (int i = 0; i < kPoints; ++i) {
    const double z = (i + 0.5) / kPoints;
    const double turn = std::numbers::pi * (1 + std::sqrt(5.0)) * i;
    const double r = std::sqrt(1 - z * z);
    const Eigen::Vector3d unit(r * std::cos(turn), r * std::sin(turn), z);
    const Eigen::Vector3d p = unit.cwiseProduct(radii_m) + Eigen::Vector3d(x_m, y_m, radii_m.z());
    cloud.push_back(
        {p.cast<float>(), unit.cwiseQuotient(radii_m).normalized().cast<float>(), color, 5e-5F});
  }
}

/// The plate's face at 0.4 mm spacing, a little rough as stereo makes it, black and white by turns.
Cloud board() {
  Cloud cloud;
  for (int i = -60; i <= 60; ++i) {
    for (int j = -60; j <= 60; ++j) {
      const double rough = 0.00004 * std::sin(12.9898 * i + 78.233 * j);
      const auto grey = static_cast<std::uint8_t>((i / 15 + j / 15) % 2 == 0 ? 40 : 220);
      cloud.push_back({Eigen::Vector3d(0.0004 * i, 0.0004 * j, rough).cast<float>(),
                       {0, 0, 1},
                       {grey, grey, grey},
                       5e-5F});
    }
  }
  return cloud;
}

const std::vector<Eigen::Vector2d> kPlaces = {
    {-0.014, -0.012}, {0.0, 0.0}, {0.013, 0.011}, {-0.012, 0.013}};

Cloud board_with_seeds() {
  Cloud cloud = board();
  for (const Eigen::Vector2d& p : kPlaces) add_seed(cloud, p.x(), p.y(), {0.004, 0.003, 0.002});
  return cloud;
}

std::vector<Eigen::Vector3d> centres(const Clusters& clusters) {
  std::vector<Eigen::Vector3d> sum(static_cast<std::size_t>(clusters.count),
                                   Eigen::Vector3d::Zero());
  std::vector<int> n(sum.size());
  for (std::size_t i = 0; i < clusters.cloud.size(); ++i) {
    if (clusters.instance[i] < 0) continue;
    sum[static_cast<std::size_t>(clusters.instance[i])] +=
        clusters.cloud[i].position_m.cast<double>();
    ++n[static_cast<std::size_t>(clusters.instance[i])];
  }
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] /= n[i];
  return sum;
}

void expect_a_cluster_at_each_place(const Clusters& clusters) {
  ASSERT_EQ(clusters.count, static_cast<int>(kPlaces.size()));
  std::set<int> found;
  for (const Eigen::Vector3d& c : centres(clusters)) {
    for (std::size_t i = 0; i < kPlaces.size(); ++i) {
      if ((c.head<2>() - kPlaces[i]).norm() < 0.0002) found.insert(static_cast<int>(i));
    }
  }
  EXPECT_EQ(found.size(), kPlaces.size());
}

TEST(BoardClusters, EachSeedIsOneCluster) {
  expect_a_cluster_at_each_place(cluster_on_board(board_with_seeds(), {}));
}

TEST(BoardClusters, GreySeedsAreFoundToo) {
  Cloud cloud = board();
  for (const Eigen::Vector2d& p : kPlaces)
    add_seed(cloud, p.x(), p.y(), {0.004, 0.003, 0.002}, {120, 120, 120});
  expect_a_cluster_at_each_place(cluster_on_board(cloud, {}));
}

TEST(BoardClusters, SidesJoinAsFarAsRoundsReach) {
  // A tower of 6 mm whose top alone faces up: rounds of 1.2 mm each reach down its side.
  Cloud cloud = board();
  const auto add = [&](float x, float y, float z, const Eigen::Vector3f& normal) {
    cloud.push_back({{x, y, z}, normal, {200, 150, 60}, 0});
  };
  for (int i = -10; i <= 10; ++i) {
    for (int j = -10; j <= 10; ++j)
      add(2e-4F * static_cast<float>(i), 2e-4F * static_cast<float>(j), 0.006F, {0, 0, 1});
    for (int k = 1; k < 30; ++k)
      add(2e-3F, 2e-4F * static_cast<float>(i), 2e-4F * static_cast<float>(k), {1, 0, 0});
  }
  const auto lowest_m = [&](int rounds) {
    BoardClusterConfig config;
    config.join_rounds = rounds;
    const Clusters clusters = cluster_on_board(cloud, config);
    EXPECT_EQ(clusters.count, 1);
    float lowest = 1;
    for (std::size_t i = 0; i < clusters.cloud.size(); ++i) {
      if (clusters.instance[i] == 0) lowest = std::min(lowest, clusters.cloud[i].position_m.z());
    }
    return lowest;
  };
  EXPECT_NEAR(lowest_m(1), 0.0048, 3e-4);
  EXPECT_NEAR(lowest_m(2), 0.0036, 5e-4);
  EXPECT_NEAR(lowest_m(8), 0.0002, 1e-6);
}

TEST(BoardClusters, APaleGrainsFootDoesNotTakeTheBoard) {
  // A pale top, its side in the same colour, and grey board that floats a millimetre up around it.
  constexpr Rgb8 kPale{200, 190, 164}, kGrey{170, 170, 168};  // saturations .18 and .01
  Cloud cloud = board();
  const auto add = [&](float x, float y, float z, const Eigen::Vector3f& normal, Rgb8 color) {
    cloud.push_back({{x, y, z}, normal, color, 0});
  };
  for (int i = -15; i <= 15; ++i) {
    for (int j = -15; j <= 15; ++j)
      add(2e-4F * static_cast<float>(i), 2e-4F * static_cast<float>(j), 0.002F, {0, 0, 1}, kPale);
    for (int k = 3; k < 10; ++k)
      add(3e-3F, 2e-4F * static_cast<float>(i), 2e-4F * static_cast<float>(k), {1, 0, 0}, kPale);
    for (int k = 1; k < 8; ++k)
      add(3e-3F + 2e-4F * static_cast<float>(k), 2e-4F * static_cast<float>(i), 0.001F, {0, 0, 1},
          kGrey);
  }
  const auto farthest_m = [&](double share) {
    BoardClusterConfig config;
    config.join_rounds = 8;
    config.join_saturation = share;
    const Clusters clusters = cluster_on_board(cloud, config);
    EXPECT_EQ(clusters.count, 1);
    float farthest = 0, lowest = 1;
    for (std::size_t i = 0; i < clusters.cloud.size(); ++i) {
      if (clusters.instance[i] != 0) continue;
      farthest = std::max(farthest, clusters.cloud[i].position_m.x());
      lowest = std::min(lowest, clusters.cloud[i].position_m.z());
    }
    EXPECT_NEAR(lowest, 0.0006, 1e-6) << share;  // the side is there either way
    return farthest;
  };
  EXPECT_NEAR(farthest_m(0), 0.0044, 1e-5);
  EXPECT_NEAR(farthest_m(0.5), 0.003, 1e-6);
}

TEST(BoardClusters, NoSeedsNoClusters) {
  const Clusters clusters = cluster_on_board(board(), {});
  EXPECT_EQ(clusters.count, 0);
  EXPECT_EQ(clusters.instance.size(), clusters.cloud.size());
  EXPECT_EQ(cluster_on_board({}, {}).count, 0);
}

TEST(BoardClusters, PointsThatAreNotFiniteAreLeftOut) {
  Cloud cloud = board_with_seeds();
  const std::size_t finite = cloud.size();
  for (std::size_t i = 0; i < 50; ++i) {
    CloudPoint p;
    p.position_m.setConstant(i % 2 == 0 ? std::nanf("") : INFINITY);
    cloud.insert(cloud.begin() + static_cast<std::ptrdiff_t>(97 * i), p);
  }
  const Clusters clusters = cluster_on_board(cloud, {});
  EXPECT_EQ(clusters.cloud.size(), finite);
  expect_a_cluster_at_each_place(clusters);
}

TEST(BoardClusters, FewPointsAreNoSeed) {
  Cloud cloud = board_with_seeds();
  for (int i = 0; i < 30; ++i)
    cloud.push_back(
        {{0.02F, -0.02F + 1e-4F * static_cast<float>(i), 0.003F}, {0, 0, 1}, kSeedColor, 0});
  expect_a_cluster_at_each_place(cluster_on_board(cloud, {}));
}

TEST(ClusterShapes, SeedsThatTouchAreNoticed) {
  Cloud cloud;
  add_seed(cloud, 0, 0, {0.005, 0.0025, 0.002});
  add_seed(cloud, 0.0098, 0, {0.005, 0.0025, 0.002});  // tip to tip
  add_seed(cloud, 0, 0.02, {0.005, 0.0025, 0.002});
  // Links through the tips: what stereo's smear does where two seeds touch.
  BoardClusterConfig config;
  config.core_distance_m = 0.0012;
  const Clusters clusters = cluster_on_board(cloud, config);
  ASSERT_EQ(clusters.count, 2);
  const std::vector<ClusterShape> shapes = cluster_shapes(clusters);
  EXPECT_TRUE(shapes[0].may_be_several);
  EXPECT_FALSE(shapes[1].may_be_several);
  // Cells of 0.3 mm round outwards, by half a cell around the ellipse's 24.2 mm.
  const double footprint_m2 = std::numbers::pi * 0.005 * 0.0025 + 0.00015 * 0.0242;
  EXPECT_NEAR(shapes[1].footprint_m2, footprint_m2, 0.04 * footprint_m2);
}

TEST(SurfacesOfClusters, HoldEachClustersPoints) {
  const Clusters clusters = cluster_on_board(board_with_seeds(), {});
  const Surfaces surfaces = surfaces_of_clusters(clusters);
  ASSERT_EQ(surfaces.size(), kPlaces.size());
  std::map<int, std::size_t> wanted;
  for (const int i : clusters.instance) ++wanted[i];
  for (const Surface& s : surfaces) {
    EXPECT_EQ(s.status, SurfaceStatus::ok);
    EXPECT_EQ(s.points_m.size(), wanted[s.instance]);
  }
}

#if COUSIN_HAS_PCL
TEST(PaperClusters, EachSeedIsOneCluster) {
  expect_a_cluster_at_each_place(cluster_as_paper(board_with_seeds(), {}, Rng(1)));
}

TEST(PaperClusters, AgreeWithOursOnSeparateSeeds) {
  const Cloud cloud = board_with_seeds();
  const auto paper = centres(cluster_as_paper(cloud, {}, Rng(1))),
             ours = centres(cluster_on_board(cloud, {}));
  ASSERT_EQ(paper.size(), ours.size());
  for (const Eigen::Vector3d& p : paper) {
    double nearest = 1;
    for (const Eigen::Vector3d& q : ours) nearest = std::min(nearest, (p - q).norm());
    EXPECT_LT(nearest,
              0.0003);  // a voxel: the paper's thins points and cuts at its plane's own distance
  }
}

TEST(PaperClusters, SameSeedSameBytes) {
  const Cloud cloud = board_with_seeds();
  const Clusters a = cluster_as_paper(cloud, {}, Rng(5)), b = cluster_as_paper(cloud, {}, Rng(5));
  EXPECT_EQ(a.instance, b.instance);
  for (std::size_t i = 0; i < a.cloud.size(); ++i)
    EXPECT_EQ(a.cloud[i].position_m, b.cloud[i].position_m);
}

TEST(PaperClusters, AVoxelHasTheMeanColourNormalAndSigmaOfItsPoints) {
  Cloud cloud;
  for (int i = 0; i < 400; ++i) {
    CloudPoint point;
    point.position_m = {0.002F * static_cast<float>(i % 20), 0.002F * static_cast<float>(i / 20),
                        0};
    point.normal = Eigen::Vector3f(0.6F, 0, 0.8F);
    point.color = {200, 40, 10};
    point.sigma_m = 1e-4F;
    cloud.push_back(point);
    point.color = {100, 60, 30};
    point.sigma_m = 3e-4F;
    cloud.push_back(point);
  }
  const Clusters clusters = cluster_as_paper(cloud, {}, Rng(1));
  ASSERT_GT(clusters.cloud.size(), 390u);  // corners are outliers
  for (const CloudPoint& point : clusters.cloud) {
    EXPECT_EQ(point.color, (Rgb8{150, 50, 20}));
    EXPECT_NEAR(point.sigma_m, 2e-4F, 1e-9);
    EXPECT_NEAR((point.normal - Eigen::Vector3f(0.6F, 0, 0.8F)).norm(), 0, 1e-6);
  }
}

TEST(PaperClusters, BoardTiltedAndTurnedOverGivesTheSameSeeds) {
  Cloud cloud = board_with_seeds();
  const Eigen::Quaternionf turn(Eigen::AngleAxisf(2.5F, Eigen::Vector3f(1, 2, 0.5F).normalized()));
  for (CloudPoint& p : cloud) p.position_m = turn * p.position_m;
  const Eigen::Vector3d up = (turn * Eigen::Vector3f::UnitZ()).cast<double>();
  EXPECT_EQ(cluster_as_paper(cloud, {}, Rng(1), up).count, static_cast<int>(kPlaces.size()));
  EXPECT_EQ(cluster_as_paper(cloud, {}, Rng(1), -up).count, 0);
}

// Centres of Gaussians: more of them hang below the board than lie on the seeds.
TEST(PaperClusters, WhatHangsBelowTheBoardIsNoSeed) {
  Cloud cloud = board_with_seeds();
  const std::size_t real = cloud.size();
  Rng rng(4);
  for (std::size_t i = 0; i < real; ++i) {
    CloudPoint point = cloud[i];
    point.position_m.z() = -0.001F - 0.004F * static_cast<float>(uniform(rng));
    cloud.push_back(point);
  }
  expect_a_cluster_at_each_place(cluster_as_paper(cloud, {}, Rng(1)));
}

TEST(PaperClusters, FarFromTheOriginCountsTheSame) {
  // Floats at 30 m are 2 micrometres apart: the cloud itself survives, single-pass float sums would
  // not.
  Cloud cloud = board_with_seeds();
  for (CloudPoint& p : cloud) p.position_m += Eigen::Vector3f(30, -20, 10);
  EXPECT_EQ(cluster_as_paper(cloud, {}, Rng(1)).count, static_cast<int>(kPlaces.size()));
}

TEST(PaperClusters, LessThanAPlaneHasNoClusters) {
  EXPECT_EQ(cluster_as_paper({}, {}, Rng(1)).count, 0);
  Cloud line;
  for (int i = 0; i < 2; ++i) line.push_back({{static_cast<float>(i), 0, 0}});
  EXPECT_EQ(cluster_as_paper(line, {.voxel_m = 0.01}, Rng(1)).count, 0);
  Cloud nan(100);
  for (CloudPoint& p : nan) p.position_m.setConstant(std::nanf(""));
  EXPECT_EQ(cluster_as_paper(nan, {}, Rng(1)).count, 0);
  Cloud same(100);
  for (CloudPoint& p : same) p.position_m.setConstant(0.5F);
  EXPECT_EQ(cluster_as_paper(same, {}, Rng(1)).count, 0);
}

TEST(PaperClusters, TooManyVoxelsIsAnError) {
  // At 1e6 m, PCL's own voxel grid would pass the cloud unthinned with a printed warning.
  Cloud cloud = board_with_seeds();
  CloudPoint far;
  far.position_m.setConstant(1e6F);
  cloud.push_back(far);
  PaperClusterConfig config;
  config.outlier_sigma = 100;
  config.outlier_neighbours = 1;
  EXPECT_ANY_THROW({
    const Clusters clusters = cluster_as_paper(cloud, config, Rng(1));
    if (clusters.count == static_cast<int>(kPlaces.size()))
      throw std::runtime_error("the far point was an outlier");
  });
}
#else
TEST(PaperClusters, SayThatTheyAreNotBuiltIn) {
  EXPECT_THROW(cluster_as_paper({}, {}, Rng(1)), NotBuilt);
}
#endif

}  // namespace
}  // namespace cousin
