#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "sim/geometry/measure.h"
#include "tests/sim/geometry/solids.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

std::vector<Vector3d> grid(int side, double step_m) {
  std::vector<Vector3d> points;
  for (int i = 0; i < side * side * side; ++i) {
    points.push_back(step_m * Vector3d(i % side, i / side % side, i / (side * side)));
  }
  return points;
}

std::vector<Vector3d> ball(int count, double radius_m, Rng rng) {
  std::vector<Vector3d> points;
  for (int i = 0; i < count; ++i) {
    const Vector3d p(normal(rng), normal(rng), normal(rng));
    points.push_back(radius_m * std::cbrt(uniform(rng)) * p.normalized());
  }
  return points;
}

TEST(AlphaShape, LargeAlphaIsTheConvexHull) {
  const auto points = random_points(200, {3, 2, 1}, Rng(1));
  const MassProperties hull = mass_properties(convex_hull(points));
  const AlphaShape shape = alpha_shape(points, 1e9);
  EXPECT_NEAR(shape.volume_m3 / hull.volume_m3, 1, 1e-10);
  EXPECT_NEAR(shape.area_m2 / hull.area_m2, 1, 1e-10);
  EXPECT_TRUE(check_watertight(shape.boundary).ok) << check_watertight(shape.boundary).problem;
}

TEST(AlphaShape, BoundaryHoldsTheVolumeItReports) {
  const auto points = ball(3000, 0.004, Rng(2));
  const AlphaShape shape = alpha_shape(points, 0.001);
  const MassProperties inside = mass_properties(shape.boundary);
  EXPECT_NEAR(inside.volume_m3 / shape.volume_m3, 1, 1e-10);
  EXPECT_NEAR(inside.area_m2 / shape.area_m2, 1, 1e-10);
  const double full = 4.0 / 3 * std::numbers::pi * std::pow(0.004, 3);
  EXPECT_LT(shape.volume_m3, full);         // inside the ball's hull
  EXPECT_GT(shape.volume_m3, 0.88 * full);  // which 3000 points fill to about that
}

TEST(AlphaShape, AGridHasNoCracks) {
  // All cells are cospherical and hold flat tetrahedra; sphere of a cell: half its diagonal, 0.87
  // steps.
  for (const Vector3d& offset : {Vector3d(0, 0, 0), Vector3d(1000, -500, 300)}) {
    const auto points = moved(grid(6, 1e-3), Eigen::Matrix3d::Identity(), offset);
    const AlphaShape shape = alpha_shape(points, 1e-3);
    EXPECT_NEAR(shape.volume_m3 / std::pow(5e-3, 3), 1, 1e-9);
    EXPECT_NEAR(shape.area_m2 / (6 * 25e-6), 1, 1e-9);
    EXPECT_TRUE(check_watertight(shape.boundary).ok) << check_watertight(shape.boundary).problem;
    EXPECT_EQ(alpha_shape(points, 0.8e-3).tetrahedra, 0);
  }
}

TEST(AlphaShape, OneTetrahedronIsKeptAboveItsRadius) {
  const auto corners = tetrahedron_mesh().vertices_m;  // on a sphere of radius sqrt 3
  EXPECT_EQ(alpha_shape(corners, 1.73).tetrahedra, 0);
  const AlphaShape shape = alpha_shape(corners, 1.74);
  EXPECT_EQ(shape.tetrahedra, 1);
  EXPECT_NEAR(shape.volume_m3, 8.0 / 3, 1e-12);
  EXPECT_TRUE(check_watertight(shape.boundary).ok);
}

TEST(AlphaShape, TwoClustersStayApart) {
  auto points = ball(400, 0.004, Rng(3));
  const AlphaShape one = alpha_shape(points, 0.0015);
  const auto other = moved(points, Eigen::Matrix3d::Identity(), {0.02, 0, 0});
  points.insert(points.end(), other.begin(), other.end());
  EXPECT_NEAR(alpha_shape(points, 0.0015).volume_m3 / one.volume_m3, 2, 1e-9);
}

TEST(AlphaShape, DoesNotDependOnPoseOrOrder) {
  const auto points = ball(800, 0.004, Rng(4));
  Rng rng(5);
  const AlphaShape here = alpha_shape(points, 0.001);
  const AlphaShape shuffled_here = alpha_shape(shuffled(points, rng.fork("order")), 0.001);
  EXPECT_EQ(shuffled_here.volume_m3, here.volume_m3);  // points are sorted first
  const AlphaShape far =
      alpha_shape(moved(points, random_rotation(rng), {1000, 2000, -500}), 0.001);
  // A sphere within rounding of alpha may fall on the other side; none does here, so only rounding
  // is left.
  EXPECT_EQ(far.tetrahedra, here.tetrahedra);
  EXPECT_NEAR(far.volume_m3 / here.volume_m3, 1, 1e-8);
  EXPECT_NEAR(far.area_m2 / here.area_m2, 1, 1e-8);
}

TEST(AlphaShape, FlatPointsHaveNoVolume) {
  for (const FlatCase& c : flat_cases()) {
    const AlphaShape shape = alpha_shape(c.points, 10);
    EXPECT_EQ(shape.volume_m3, 0) << c.name;
    EXPECT_TRUE(shape.boundary.triangles.empty()) << c.name;
  }
  EXPECT_EQ(alpha_shape({}, 1).tetrahedra, 0);
}

TEST(AlphaShape, BadInputIsTheCallersMistake) {
  const auto points = grid(2, 1);
  EXPECT_THROW(alpha_shape(points, 0), std::invalid_argument);
  EXPECT_THROW(alpha_shape(points, std::numeric_limits<double>::quiet_NaN()),
               std::invalid_argument);
  auto bad = points;
  bad[3].z() = std::numeric_limits<double>::infinity();
  EXPECT_THROW(alpha_shape(bad, 1), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
