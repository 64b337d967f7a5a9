#include "sim/physics/convex_parts.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <stdexcept>

#include "sim/geometry/measure.h"
#include "tests/sim/physics/solids.h"

namespace cousin {
namespace {

double volume_m3(const std::vector<Mesh>& hulls) {
  double sum = 0;
  for (const Mesh& hull : hulls) sum += mass_properties(hull).volume_m3;
  return sum;
}

/// How far a point is outside the nearest of the hulls; 0 inside one.
double outside_m(const Eigen::Vector3d& point, const std::vector<Mesh>& hulls) {
  double nearest = 1e9;
  for (const Mesh& hull : hulls) {
    double out = 0;
    for (const auto& t : hull.triangles) {
      const Eigen::Vector3d& a = hull.vertices_m[t[0]];
      const Eigen::Vector3d normal = (hull.vertices_m[t[1]] - a).cross(hull.vertices_m[t[2]] - a);
      if (normal.norm() > 1e-15) out = std::max(out, normal.normalized().dot(point - a));
    }
    nearest = std::min(nearest, out);
  }
  return nearest;
}

TEST(ConvexParts, AConvexSolidStaysOnePart) {
  const Mesh mesh = ellipsoid_solid({0.004, 0.002, 0.0015});
  const ConvexParts parts = convex_parts(mesh);
  ASSERT_EQ(parts.hulls.size(), 1U);
  EXPECT_NEAR(parts.excess, 0, 1e-9);  // the mesh is its own hull: rounding only
  EXPECT_LT(parts.hulls[0].vertices_m.size(), mesh.vertices_m.size() / 2);
}

TEST(ConvexParts, ThinningLeavesNoCornerFartherOutsideThanStated) {
  const Mesh mesh = ellipsoid_solid({0.004, 0.002, 0.0015});
  const ConvexPartsConfig config;
  const ConvexParts parts = convex_parts(mesh, config);
  for (const Eigen::Vector3d& vertex : mesh.vertices_m) {
    EXPECT_LE(outside_m(vertex, parts.hulls), config.follow_m + 1e-12);
  }
}

TEST(ConvexParts, ADumbbellIsCutUntilTheHullsFollowIt) {
  const Mesh mesh = ellipsoid_solid({0.006, 0.002, 0.002}, 0.5);
  const ConvexParts one = convex_parts(mesh, {.max_parts = 1});
  const ConvexParts parts = convex_parts(mesh, {.max_gap_m = 5e-6, .max_parts = 16});
  EXPECT_GT(one.excess, 0.1);
  EXPECT_LT(parts.gap_m, 0.1 * one.gap_m);
  EXPECT_GT(parts.hulls.size(), 2U);
}

TEST(ConvexParts, PartsCoverTheSolidHoweverOftenItIsCut) {
  // Cuts along all three axes: the corners where cut faces meet lie inside the solid and must not
  // be lost.
  const Mesh mesh = ellipsoid_solid({0.004, 0.003, 0.0025}, 0.3);
  const double solid_m3 = mass_properties(mesh).volume_m3;
  for (const int count : {2, 4, 8, 16}) {
    const ConvexParts parts = convex_parts(mesh, {.max_gap_m = 1e-9, .max_parts = count});
    EXPECT_GE(parts.excess, -1e-9) << count << " parts";
    // Thinning takes at most follow_m off the surface of each part; twice for the cut faces.
    const ConvexPartsConfig config;
    EXPECT_GE(volume_m3(parts.hulls),
              solid_m3 - 4 * config.follow_m * mass_properties(mesh).area_m2)
        << count;
  }
}

TEST(ConvexParts, AFlatMeshIsRefused) {
  Mesh flat;
  flat.vertices_m = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  flat.triangles = {{0, 1, 2}, {0, 2, 1}};
  EXPECT_THROW(convex_parts(flat), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
