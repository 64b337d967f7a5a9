#include "benchmarks/score/surface_distance.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace cousin {
namespace {

/// Unit cube [0, 1]^3, outward.
Mesh cube() {
  Mesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices_m.push_back({double(i & 1), double(i >> 1 & 1), double(i >> 2)});
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

TEST(PointTriangleDistance, KnowsFaceEdgeAndCorner) {
  const Eigen::Vector3d a(0, 0, 0), b(2, 0, 0), c(0, 2, 0);
  EXPECT_NEAR(point_triangle_distance_m({0.5, 0.5, 3}, a, b, c), 3, 1e-15);
  EXPECT_NEAR(point_triangle_distance_m({1, -2, 0}, a, b, c), 2, 1e-15);
  EXPECT_NEAR(point_triangle_distance_m({-3, -4, 12}, a, b, c), 13, 1e-14);
  EXPECT_NEAR(point_triangle_distance_m({2, 2, 0}, a, b, c), std::sqrt(2.0), 1e-15);
}

TEST(PointTriangleDistance, TakesTrianglesThatAreLinesOrPoints) {
  const Eigen::Vector3d a(0, 0, 0), b(1, 0, 0);
  EXPECT_NEAR(point_triangle_distance_m({0.5, 2, 0}, a, b, b), 2, 1e-15);
  EXPECT_NEAR(point_triangle_distance_m({0.5, 2, 0}, a, a, b), 2, 1e-15);
  EXPECT_NEAR(point_triangle_distance_m({3, 4, 0}, a, a, a), 5, 1e-15);
}

TEST(DistanceTree, AgreesWithTryingEveryTriangle) {
  Rng rng(1);
  Mesh soup;
  for (int i = 0; i < 900; ++i) soup.vertices_m.push_back({normal(rng), normal(rng), normal(rng)});
  for (std::uint32_t i = 0; i < 300; ++i) soup.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  const DistanceTree tree(soup);
  const DistanceTree points(soup.vertices_m);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d p = 2 * Eigen::Vector3d(normal(rng), normal(rng), normal(rng));
    double best = std::numeric_limits<double>::infinity();
    double nearest = best;
    for (const auto& [a, b, c] : soup.triangles) {
      best = std::min(best, point_triangle_distance_m(p, soup.vertices_m[a], soup.vertices_m[b],
                                                      soup.vertices_m[c]));
    }
    for (const Eigen::Vector3d& v : soup.vertices_m) nearest = std::min(nearest, (p - v).norm());
    EXPECT_EQ(tree.distance_m(p), best);
    EXPECT_EQ(points.distance_m(p), nearest);
  }
}

TEST(DistanceTree, TheNormalIsOfTheNearestTriangles) {
  const DistanceTree tree(cube());
  EXPECT_NEAR((tree.normal_at({0.3, 0.4, 2}) - Eigen::Vector3d(0, 0, 1)).norm(), 0, 1e-12);
  EXPECT_NEAR((tree.normal_at({0.3, 0.4, 0.9}) - Eigen::Vector3d(0, 0, 1)).norm(), 0, 1e-12);
  EXPECT_NEAR((tree.normal_at({0.5, -1, -1}) - Eigen::Vector3d(0, -1, -1).normalized()).norm(), 0,
              1e-12);
  EXPECT_NEAR((tree.normal_at({2, 2, 2}) - Eigen::Vector3d(1, 1, 1).normalized()).norm(), 0, 1e-12);
  EXPECT_TRUE(DistanceTree(cube().vertices_m).normal_at({2, 2, 2}).isZero());
}

TEST(ScoreNormals, AreAnglesToTheSurfaceBelowThem) {
  const std::vector<Eigen::Vector3d> points = {
      {0.5, 0.5, 1.1}, {0.5, 0.5, 1}, {0.2, 0.3, 0.95}, {1.2, 0.5, 0.5}, {0.5, 0.5, -1}};
  const std::vector<Eigen::Vector3d> normals = {{0, std::sin(0.1), std::cos(0.1)},
                                                {0, 0, 5},
                                                {std::sin(0.3), 0, std::cos(0.3)},
                                                {0, 0, 0},
                                                {0, 0, 1}};
  const NormalScore score = score_normals(points, normals, cube());
  EXPECT_EQ(score.measured, 4);
  EXPECT_EQ(score.points, 5);
  EXPECT_NEAR(score.median_rad, 0.2, 1e-9);
  EXPECT_NEAR(score.p95_rad, 0.3 + 0.85 * (std::numbers::pi - 0.3), 1e-9);  // the last is inward
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  for (const auto& [where, way] :
       {std::pair(Eigen::Vector3d(0, 0, kNaN), Eigen::Vector3d(0, 0, 1)),
        std::pair(Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0, kNaN, 1))})
    EXPECT_THROW(score_normals({&where, 1}, {&way, 1}, cube()), std::invalid_argument);
  EXPECT_THROW(score_normals(points, std::span(normals).first(4), cube()), std::invalid_argument);
  EXPECT_THROW(score_normals(points, normals, Mesh{}), std::invalid_argument);
  EXPECT_TRUE(std::isnan(score_normals({}, {}, cube()).median_rad));
}

TEST(DistanceTree, KeepsItsPrecisionFarFromTheOrigin) {
  Mesh mesh = cube();
  for (Eigen::Vector3d& v : mesh.vertices_m) v = 1e-3 * v + Eigen::Vector3d(1e6, -1e6, 1e6);
  const DistanceTree tree(mesh);
  // Positions near 1e6 m are multiples of 1.2e-10 m in double.
  EXPECT_NEAR(tree.distance_m(Eigen::Vector3d(1e6 + 0.0005, -1e6 + 0.0005, 1e6 + 0.003)), 0.002,
              1e-9);
}

TEST(DistanceTree, RejectsWhatHasNoDistance) {
  EXPECT_THROW(DistanceTree(Mesh{}), std::invalid_argument);
  EXPECT_THROW(DistanceTree(std::span<const Eigen::Vector3d>{}), std::invalid_argument);
  Mesh mesh = cube();
  mesh.triangles[0][0] = 8;
  EXPECT_THROW(DistanceTree{mesh}, std::invalid_argument);
  mesh = cube();
  mesh.vertices_m[3].x() = std::nan("");
  EXPECT_THROW(DistanceTree{mesh}, std::invalid_argument);
}

TEST(SampleSurface, IsEvenOverTheArea) {
  Mesh mesh = cube();
  const std::vector<Eigen::Vector3d> samples = sample_surface(mesh, 60000, Rng(2));
  const DistanceTree tree(mesh);
  int top = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : samples) {
    EXPECT_LT(tree.distance_m(p), 1e-15);
    top += p.z() > 1 - 1e-12 ? 1 : 0;
    sum += p;
  }
  EXPECT_NEAR(top, 10000, 3);  // stratified: exact but for the strata that straddle
  // Variance of a coordinate over a cube's surface is 1/12 to 1/4; five standard errors.
  EXPECT_LT((sum / 60000 - Eigen::Vector3d::Constant(0.5)).norm(), 5 * 0.5 / std::sqrt(60000.0));
  EXPECT_THROW(sample_surface(Mesh{}, 10, Rng(1)), std::invalid_argument);
}

TEST(ScoreCloud, TruthScoresPerfectlyAndAnOffsetScoresItself) {
  const Mesh mesh = cube();
  const std::vector<Eigen::Vector3d> samples = sample_surface(mesh, 20000, Rng(2));
  const std::vector<double> tolerances = {0.01, 0.05, 0.11};
  const CloudScore perfect = score_cloud(samples, mesh, samples, tolerances);
  EXPECT_LT(perfect.accuracy_rms_m, 1e-15);
  EXPECT_LT(std::abs(perfect.bias_m), 1e-15);
  EXPECT_EQ(perfect.completeness_mean_m, 0);
  for (const auto& at : perfect.at) EXPECT_EQ(at.f1, 1);

  // A larger cube: every point lies 0.1 outside a face, or up to 0.1 sqrt(3) at edges.
  std::vector<Eigen::Vector3d> grown;
  for (const Eigen::Vector3d& p : samples) {
    const Eigen::Vector3d q = p - Eigen::Vector3d::Constant(0.5);
    Eigen::Index axis = 0;
    q.cwiseAbs().maxCoeff(&axis);
    Eigen::Vector3d moved = p;
    moved[axis] += q[axis] > 0 ? 0.1 : -0.1;
    grown.push_back(moved);
  }
  const CloudScore offset = score_cloud(grown, mesh, samples, tolerances);
  EXPECT_NEAR(offset.accuracy_mean_m, 0.1, 1e-12);
  EXPECT_NEAR(offset.bias_m, 0.1, 1e-12);
  EXPECT_NEAR(offset.accuracy_median_m, 0.1, 1e-12);
  EXPECT_NEAR(offset.accuracy_p95_m, 0.1, 1e-12);
  EXPECT_EQ(offset.at[1].precision, 0);
  EXPECT_EQ(offset.at[2].precision, 1);
}

TEST(DistanceTree, TheSignSaysWhichSideBesideSharpEdges) {
  // A flat wedge, off the axes: beside its thin edge a point is in front of one face and behind the
  // other, both equally near.
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  Mesh mesh;
  for (const Eigen::Vector3d& corner :
       {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(1, 0.5, 0.1),
        Eigen::Vector3d(1, 0.5, -0.1)})
    mesh.vertices_m.push_back(turn * corner);
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  const DistanceTree tree(mesh);
  Rng rng(5);
  int inside = 0;
  for (int i = 0; i < 4000; ++i) {
    const Eigen::Vector3d p(uniform(rng, -0.2, 1.2), uniform(rng, -0.2, 1.2),
                            uniform(rng, -0.2, 0.2));
    const double distance_m = tree.signed_distance_m(turn * p);
    bool within = true;
    for (const auto& t : mesh.triangles) {
      const Eigen::Vector3d a = mesh.vertices_m[t[0]];
      const Eigen::Vector3d normal = (mesh.vertices_m[t[1]] - a).cross(mesh.vertices_m[t[2]] - a);
      within = within && normal.dot(turn * p - a) < 0;
    }
    inside += within ? 1 : 0;
    EXPECT_EQ(distance_m < 0, within) << p.transpose();
    EXPECT_EQ(std::abs(distance_m), tree.distance_m(turn * p));
  }
  EXPECT_GT(inside, 50);
}

TEST(ScoreCloud, HalfACloudIsHalfComplete) {
  const Mesh mesh = cube();
  const std::vector<Eigen::Vector3d> samples = sample_surface(mesh, 20000, Rng(2));
  std::vector<Eigen::Vector3d> half;
  for (const Eigen::Vector3d& p : samples) {
    if (p.x() < 0.5) half.push_back(p);
  }
  const CloudScore score = score_cloud(half, mesh, samples, std::vector<double>{1e-9});
  EXPECT_EQ(score.at[0].precision, 1);
  EXPECT_NEAR(score.at[0].recall, 0.5, 0.02);  // 20000 samples: 0.35 %, five times
  EXPECT_NEAR(score.at[0].f1, 2 * score.at[0].recall / (1 + score.at[0].recall), 1e-12);
}

TEST(ScoreCloud, AnEmptyCloudScoresZero) {
  const Mesh mesh = cube();
  const CloudScore score =
      score_cloud({}, mesh, sample_surface(mesh, 10, Rng(1)), std::vector<double>{0.1});
  EXPECT_TRUE(std::isnan(score.accuracy_mean_m));
  EXPECT_EQ(score.at[0].precision, 0);
  EXPECT_EQ(score.at[0].recall, 0);
  EXPECT_EQ(score.at[0].f1, 0);
  EXPECT_THROW(score_cloud({}, mesh, {}, {}), std::invalid_argument);
}

TEST(ScoreCloud, IsTheSameOnAnyNumberOfThreads) {
  const Mesh mesh = cube();
  const std::vector<Eigen::Vector3d> cloud = sample_surface(mesh, 5000, Rng(2));
  const std::vector<Eigen::Vector3d> samples = sample_surface(mesh, 5000, Rng(3));
  const auto run = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return score_cloud(cloud, mesh, samples, std::vector<double>{0.01}).completeness_mean_m;
  };
  const double one = run(1);
  EXPECT_EQ(run(2), one);
  EXPECT_EQ(run(7), one);
}

TEST(ScoreMesh, RecallDoesNotDependOnHowManyPointsAreDrawn) {
  const Mesh mesh = cube();
  const std::vector<Eigen::Vector3d> few = sample_surface(mesh, 10, Rng(1));
  const std::vector<Eigen::Vector3d> many = sample_surface(mesh, 500, Rng(2));
  const std::vector<double> tolerances = {1e-9};
  EXPECT_EQ(score_mesh(mesh, few, mesh, many, tolerances).at[0].recall, 1);
  EXPECT_LT(score_cloud(few, mesh, many, tolerances).at[0].recall, 0.5);
  Mesh open = mesh;
  open.triangles.resize(10);  // without the side x = 1
  EXPECT_NEAR(score_mesh(open, few, mesh, many, tolerances).at[0].recall, 5.0 / 6, 0.01);
}

}  // namespace
}  // namespace cousin
