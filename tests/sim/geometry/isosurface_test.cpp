#include "sim/geometry/isosurface.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "sim/geometry/measure.h"
#include "sim/types/rng.h"

namespace cousin {
namespace {

ValueLattice lattice_of(int size, double step_m,
                        const std::function<double(const Eigen::Vector3d&)>& value) {
  ValueLattice lattice{.low_m = Eigen::Vector3d::Constant(-0.5 * step_m * (size - 1)),
                       .step_m = step_m,
                       .size = {size, size, size}};
  for (int z = 0; z < size; ++z) {
    for (int y = 0; y < size; ++y) {
      for (int x = 0; x < size; ++x)
        lattice.values.push_back(static_cast<float>(value(lattice.point_m(x, y, z))));
    }
  }
  return lattice;
}

TEST(Isosurface, ASphereIsClosedAndHasItsVolumeAndArea) {
  const double radius = 0.8;
  const Mesh mesh =
      isosurface(lattice_of(41, 0.05, [&](const Eigen::Vector3d& p) { return p.norm() - radius; }));
  const MeshCheck check = check_watertight(mesh);
  EXPECT_TRUE(check.ok) << check.problem;
  const MassProperties mass = mass_properties(mesh);
  // Edges are up to sqrt(3) steps long: linear interpolation is off inwards by an edge's square
  // over 8 radii, 1.2e-3 at most, and a third of it on average; flat triangles by as much.
  const double volume = 4.0 / 3 * std::numbers::pi * radius * radius * radius;
  EXPECT_NEAR(mass.volume_m3, volume, 0.003 * volume);
  const double area = 4 * std::numbers::pi * radius * radius;
  EXPECT_NEAR(mass.area_m2, area, 0.003 * area);
  double worst_m = 0;
  for (const Eigen::Vector3d& v : mesh.vertices_m)
    worst_m = std::max(worst_m, std::abs(v.norm() - radius));
  EXPECT_LT(worst_m, 1.2e-3 + 1e-3 * 0.087);  // and a thousandth of an edge off lattice points
}

TEST(Isosurface, APlaneIsMetExactly) {
  const Eigen::Vector3d normal = Eigen::Vector3d(1, 2, 3).normalized();
  const Mesh mesh = isosurface(
      lattice_of(12, 0.1, [&](const Eigen::Vector3d& p) { return normal.dot(p) - 0.0123; }));
  ASSERT_FALSE(mesh.triangles.empty());
  // Floats of values up to 1 round to 6e-8; a vertex is kept 1e-4 off a lattice point.
  for (const Eigen::Vector3d& v : mesh.vertices_m) EXPECT_NEAR(normal.dot(v), 0.0123, 2e-4);
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d& a = mesh.vertices_m[t[0]];
    const Eigen::Vector3d across = (mesh.vertices_m[t[1]] - a).cross(mesh.vertices_m[t[2]] - a);
    EXPECT_GT(across.dot(normal), 0);  // outward: to larger values
  }
}

TEST(Isosurface, AnySignsInsideABorderGiveAClosedSurface) {
  // Noise makes every case of a tetrahedron; zeros lie exactly on lattice points.
  Rng rng(4);
  ValueLattice lattice = lattice_of(9, 1, [&](const Eigen::Vector3d& p) {
    if (p.cwiseAbs().maxCoeff() > 3.5) return 1.0;
    return std::floor(uniform(rng, -2, 3));
  });
  const Mesh mesh = isosurface(lattice);
  ASSERT_GT(mesh.triangles.size(), 500u);
  const MeshCheck check = check_watertight(mesh);
  EXPECT_EQ(check.open_edges, 0) << check.problem;
  EXPECT_EQ(check.degenerate_triangles, 0);
}

TEST(Isosurface, AllOnOneSideIsNoSurface) {
  EXPECT_TRUE(isosurface(lattice_of(4, 1, [](const auto&) { return 1.0; })).triangles.empty());
  EXPECT_TRUE(isosurface(lattice_of(4, 1, [](const auto&) { return -1.0; })).triangles.empty());
  EXPECT_TRUE(isosurface(ValueLattice{}).triangles.empty());
}

TEST(Isosurface, RefusesLatticesThatAreNone) {
  ValueLattice lattice = lattice_of(4, 1, [](const auto&) { return 1.0; });
  lattice.values[5] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(isosurface(lattice), std::invalid_argument);
  lattice.values.pop_back();
  EXPECT_THROW(isosurface(lattice), std::invalid_argument);
  EXPECT_THROW(isosurface({.size = {65536, 65536, 65536}}), std::invalid_argument);
  EXPECT_THROW(isosurface({.size = {-1, 1, 1}}), std::invalid_argument);
  lattice = lattice_of(4, 1, [](const auto&) { return 1.0; });
  lattice.step_m = 0;
  EXPECT_THROW(isosurface(lattice), std::invalid_argument);
}

TEST(LargeParts, DropsWhatIsSmallAndKeepsTheRestClosed) {
  const Mesh both = isosurface(lattice_of(41, 0.05, [](const Eigen::Vector3d& p) {
    return std::min((p - Eigen::Vector3d(-0.3, 0, 0)).norm() - 0.5,
                    (p - Eigen::Vector3d(0.6, 0, 0)).norm() - 0.15);
  }));
  const Mesh one = large_parts(both, 0.2);  // areas are as 1 : 0.09
  EXPECT_TRUE(check_watertight(one).ok);
  const double volume = 4.0 / 3 * std::numbers::pi * 0.125;
  EXPECT_NEAR(mass_properties(one).volume_m3, volume, 0.006 * volume);
  EXPECT_EQ(large_parts(both, 0.05).triangles.size(), both.triangles.size());
  EXPECT_TRUE(large_parts(Mesh{}, 0.5).triangles.empty());
}

}  // namespace
}  // namespace cousin
