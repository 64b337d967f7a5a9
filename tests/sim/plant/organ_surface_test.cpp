#include "sim/plant/organ_surface.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sim/geometry/measure.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

LineWalk straight(double length_m) {
  AxisGrowth growth;
  growth.heading = Vector3d::UnitX();
  growth.length_m = length_m;
  return {grow_axis(growth), Vector3d::UnitZ()};
}

/// As wide everywhere, but for the last row, which is a point.
BladeShape strip(double width_m) {
  BladeShape shape;
  shape.width_m = width_m;
  shape.envelope_base = 1;
  shape.envelope_peak = 0.5;
  shape.envelope_fall = 1e6;
  return shape;
}

TEST(TubeSurface, IsClosedAndHasTheCylindersVolume) {
  AxisGrowth growth;
  growth.length_m = 0.1;
  growth.radius_base_m = growth.radius_tip_m = 0.004;
  growth.curls.push_back({Vector3d::UnitY(), 0.6, 0});
  const Mesh mesh = tube_surface(grow_axis(growth), 64).mesh;
  const MeshCheck check = check_watertight(mesh);
  EXPECT_TRUE(check.ok) << check.problem;
  const double cylinder = std::numbers::pi * 0.004 * 0.004 * 0.1;
  const double cap = 2.0 / 3 * std::numbers::pi * 0.004 * 0.004 * 0.002;  // half an ellipsoid
  const double volume = mass_properties(mesh).volume_m3;
  // A polygon of 64 sides has 0.16 % less area than its circle, and so do arcs of 16 steps.
  EXPECT_GT(volume, cylinder * (1 - 0.003));
  EXPECT_LT(volume, cylinder + 2 * cap);
}

TEST(TubeSurface, RefusesTwoSides) {
  EXPECT_THROW(tube_surface(grow_axis({}), 2), std::invalid_argument);
}

TEST(BladeSurface, AStripsAreaIsLengthTimesWidth) {
  const OrganSurface blade = blade_surface(straight(0.08), strip(0.03), 40, 8);
  // The last of 40 rows is a point: half a row is missing.
  EXPECT_NEAR(surface_area_m2(blade.mesh), 0.08 * 0.03 * (1 - 0.5 / 40), 1e-15);
}

TEST(BladeSurface, ATrianglesAreaIsHalfAndAParabolasTwoThirds) {
  BladeShape shape = strip(0.03);
  shape.envelope_peak = 1e-9;
  shape.envelope_fall = 1;
  EXPECT_NEAR(surface_area_m2(blade_surface(straight(0.08), shape, 40, 8).mesh), 0.5 * 0.08 * 0.03,
              1e-10);
  shape.envelope_fall = 2;
  // The chords of n rows leave 1 / (6 n^2) of the width's second difference.
  EXPECT_NEAR(surface_area_m2(blade_surface(straight(0.08), shape, 200, 8).mesh),
              2.0 / 3 * 0.08 * 0.03, 1e-5 * 0.08 * 0.03);
}

TEST(BladeSurface, BendingTheMidribKeepsTheArea) {
  AxisGrowth growth;
  growth.heading = Vector3d::UnitX();
  growth.length_m = 0.08;
  growth.segments = 200;
  growth.curls.push_back({Vector3d::UnitY(), 1.5, 0});
  const LineWalk bent(grow_axis(growth), Vector3d::UnitZ());
  const double area = surface_area_m2(blade_surface(bent, strip(0.03), 200, 8).mesh);
  // A sheet bent about one direction is not stretched; chords of arcs of 1.5 / 200 rad.
  EXPECT_NEAR(area, 0.08 * 0.03 * (1 - 0.5 / 200), 1e-5 * 0.08 * 0.03);
}

TEST(BladeSurface, FoldingAboutTheMidribKeepsTheArea) {
  BladeShape shape = strip(0.03);
  shape.fold_rad = 0.7;
  EXPECT_NEAR(surface_area_m2(blade_surface(straight(0.08), shape, 40, 8).mesh),
              0.08 * 0.03 * (1 - 0.5 / 40), 1e-15);
}

TEST(BladeSurface, UpperSideFacesAlongTheMidribsNormals) {
  BladeShape shape = strip(0.03);
  shape.sweep_base_rad = 2.1;
  shape.sweep_tip_rad = 0.4;
  const Mesh mesh = blade_surface(straight(0.08), shape, 40, 8).mesh;
  for (const auto& t : mesh.triangles) {
    const Vector3d& a = mesh.vertices_m[t[0]];
    const Vector3d normal = (mesh.vertices_m[t[1]] - a).cross(mesh.vertices_m[t[2]] - a);
    EXPECT_GT(normal.z(), -1e-18);
  }
}

TEST(BladeSurface, ALobedLeafDoesNotFoldBackAtItsTip) {
  BladeShape shape;
  shape.width_m = 0.08;
  shape.envelope_base = 0.7;
  shape.envelope_peak = 0.27;
  shape.envelope_fall = 1.3;
  shape.sweep_base_rad = 2.2;
  shape.sweep_tip_rad = 0.8;
  const Mesh mesh = blade_surface(straight(0.08), shape, 60, 20).mesh;
  double flat_m2 = 0;
  for (const auto& t : mesh.triangles) {
    const Vector3d& a = mesh.vertices_m[t[0]];
    flat_m2 += 0.5 * (mesh.vertices_m[t[1]] - a).cross(mesh.vertices_m[t[2]] - a).z();
  }
  // Signed and unsigned areas agree: nothing lies upside down.
  EXPECT_NEAR(flat_m2, surface_area_m2(mesh), 1e-15);
  for (const Vector3d& vertex : mesh.vertices_m) EXPECT_LE(vertex.x(), 0.08 + 1e-12);
}

TEST(BladeSurface, LobesCutTheOutlineAsDeepAsSaid) {
  BladeShape shape = strip(0.03);
  shape.lobes = 3;
  shape.lobe_depth = 0.5;
  EXPECT_NEAR(row_share(shape, 1.0 / 3), 0.5, 1e-12);  // between two lobes
  EXPECT_NEAR(row_share(shape, 0.5), 1, 1e-12);        // the middle lobe
  EXPECT_EQ(side_veins(shape).size(), 3U);
}

TEST(BladeSurface, RefusesAWidthOfNothingAndOddColumns) {
  EXPECT_THROW(blade_surface(straight(0.08), strip(0), 40, 8), std::invalid_argument);
  EXPECT_THROW(blade_surface(straight(0.08), strip(0.03), 40, 7), std::invalid_argument);
  EXPECT_THROW(blade_surface(straight(0.08), strip(0.03), 1, 8), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
