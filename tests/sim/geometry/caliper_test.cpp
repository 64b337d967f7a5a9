#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "sim/geometry/measure.h"
#include "tests/sim/geometry/solids.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

/// Width over the normals of all point triples and all pairs of point pairs, which hold the
/// minimum; O(n^4 n).
double brute_force_width(const std::vector<Vector3d>& points) {
  std::vector<Vector3d> edges;
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = i + 1; j < points.size(); ++j) edges.push_back(points[j] - points[i]);
  }
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < edges.size(); ++i) {
    for (std::size_t j = i + 1; j < edges.size(); ++j) {
      const Vector3d normal = edges[i].cross(edges[j]);
      if (normal.norm() < 1e-9) continue;
      double low = std::numeric_limits<double>::infinity(), high = -low;
      for (const Vector3d& p : points) {
        low = std::min(low, normal.dot(p));
        high = std::max(high, normal.dot(p));
      }
      best = std::min(best, (high - low) / normal.norm());
    }
  }
  return best;
}

TEST(Hull, IsClosedConvexAndHoldsAllPoints) {
  for (const int count : {4, 5, 20, 500}) {
    const std::vector<Vector3d> points =
        random_points(count, {3, 2, 1}, Rng(2).fork(static_cast<std::uint64_t>(count)));
    const Mesh hull = convex_hull(points);
    ASSERT_TRUE(check_watertight(hull).ok) << count;
    for (const auto& t : hull.triangles) {
      const Vector3d& a = hull.vertices_m[t[0]];
      const Vector3d normal =
          (hull.vertices_m[t[1]] - a).cross(hull.vertices_m[t[2]] - a).normalized();
      for (const Vector3d& p : points) ASSERT_LT(normal.dot(p - a), 1e-12);
    }
  }
}

TEST(Hull, CoplanarFacesStayClosed) {
  std::vector<Vector3d> grid;
  for (int i = 0; i < 216; ++i) grid.emplace_back(i % 6, i / 6 % 6, i / 36);
  const Mesh hull = convex_hull(grid);
  EXPECT_TRUE(check_watertight(hull).ok) << check_watertight(hull).problem;
  EXPECT_NEAR(mass_properties(hull).volume_m3, 125, 1e-10);
}

TEST(Hull, FlatPointsHaveNone) {
  for (const FlatCase& c : flat_cases())
    EXPECT_TRUE(convex_hull(c.points).triangles.empty()) << c.name;
  EXPECT_THROW(convex_hull({}), std::invalid_argument);
}

TEST(Caliper, BoxHasItsDiagonalAndItsShortestSide) {
  Rng rng(3);
  for (int trial = 0; trial < 20; ++trial) {
    const Vector3d size(0.008, 0.005, 0.003);
    const auto points = moved(box_mesh(size).vertices_m, random_rotation(rng), {0.3, -0.2, 0.1});
    const CaliperDiameters d = caliper_diameters(points);
    EXPECT_NEAR(d.maximum_m / size.norm(), 1, 1e-12);
    EXPECT_NEAR(d.minimum_m / 0.003, 1, 1e-12);
  }
}

TEST(Caliper, TetrahedronIsNarrowestBetweenTwoEdges) {
  // Opposite edges of the regular tetrahedron in a cube of side 2 lie in opposite faces of the
  // cube; a face and its opposite corner are 4 / sqrt 3 = 2.31 apart.
  const CaliperDiameters d = caliper_diameters(tetrahedron_mesh().vertices_m);
  EXPECT_NEAR(d.minimum_m, 2, 1e-12);
  EXPECT_NEAR(d.maximum_m, std::sqrt(8.0), 1e-12);
}

TEST(Caliper, EqualsBruteForceOnSmallSets) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const auto points =
        random_points(4 + static_cast<int>(seed % 9), {1, 0.8, seed % 2 ? 0.3 : 1.0}, Rng(seed));
    const CaliperDiameters d = caliper_diameters(points);
    EXPECT_NEAR(d.minimum_m, brute_force_width(points), 1e-12) << seed;
    double longest = 0;
    for (const Vector3d& a : points) {
      for (const Vector3d& b : points) longest = std::max(longest, (a - b).norm());
    }
    EXPECT_DOUBLE_EQ(d.maximum_m, longest);
  }
}

TEST(Caliper, FlatPointsHaveNoWidth) {
  for (const FlatCase& c : flat_cases()) {
    const CaliperDiameters d = caliper_diameters(c.points);
    EXPECT_EQ(d.minimum_m, 0) << c.name;
    double longest = 0;
    for (const Vector3d& a : c.points) {
      for (const Vector3d& b : c.points) longest = std::max(longest, (a - b).norm());
    }
    EXPECT_NEAR(d.maximum_m, longest, 1e-12) << c.name;
  }
}

}  // namespace
}  // namespace cousin
