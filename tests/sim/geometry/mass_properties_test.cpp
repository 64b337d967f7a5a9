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
using std::numbers::pi;

TEST(MassProperties, BoxHasTheTextbooksValuesAnywhere) {
  const Vector3d size(0.008, 0.005, 0.003);
  Rng rng(1);
  for (const Vector3d& centre :
       {Vector3d(0, 0, 0), Vector3d(0.1, -0.2, 0.3), Vector3d(1000, -400, 70)}) {
    const Eigen::Matrix3d rotation = random_rotation(rng);
    const MassProperties m = mass_properties(moved(box_mesh(size), rotation, centre));
    // Coordinates are rounded to half an ulp of the offset; a size of 3 mm then has this relative
    // error.
    const double tolerance =
        1e-13 + 10 * centre.norm() * std::numeric_limits<double>::epsilon() / 0.003;
    EXPECT_NEAR(m.volume_m3 / size.prod(), 1, tolerance);
    EXPECT_NEAR(m.area_m2 / (2 * (0.008 * 0.005 + 0.005 * 0.003 + 0.003 * 0.008)), 1, tolerance);
    EXPECT_LT((m.centroid_m - centre).norm(), 0.003 * tolerance + centre.norm() * 1e-15);
    const Vector3d squared = size.cwiseAbs2();
    const Vector3d moments = size.prod() / 12 * (Vector3d::Constant(squared.sum()) - squared);
    const Eigen::Matrix3d expected = rotation * moments.asDiagonal() * rotation.transpose();
    EXPECT_LT((m.inertia_m5 - expected).norm() / expected.norm(), 10 * tolerance);
  }
}

TEST(MassProperties, EllipsoidConvergesQuadratically) {
  const Vector3d r(4, 3, 2);
  const double volume = 4.0 / 3 * pi * r.prod();
  double previous = 0;
  for (int levels = 3; levels <= 5; ++levels) {
    const MassProperties m = mass_properties(ellipsoid_mesh(r, levels));
    const double error = 1 - m.volume_m3 / volume;
    EXPECT_GT(error, 0);  // inscribed
    // The error of chords falls with the square of their length: a quarter for each halving.
    if (previous > 0) EXPECT_NEAR(previous / error, 4, 0.2);
    previous = error;
  }
  EXPECT_LT(previous, 2e-3);
  const MassProperties fine = mass_properties(ellipsoid_mesh(r, 6));
  EXPECT_NEAR(fine.inertia_m5(0, 0) / (volume / 5 * (9 + 4)), 1, 2e-3);
  EXPECT_LT(fine.centroid_m.norm(), 1e-12);
}

TEST(MassProperties, SphereAreaConverges) {
  const MassProperties m = mass_properties(ellipsoid_mesh(Vector3d::Constant(0.011), 6));
  EXPECT_NEAR(m.area_m2 / (4 * pi * 0.011 * 0.011), 1, 1e-3);
}

TEST(MassProperties, InsideOutIsNegative) {
  Mesh mesh = tetrahedron_mesh();
  EXPECT_NEAR(mass_properties(mesh).volume_m3, 8.0 / 3, 1e-15);
  for (auto& t : mesh.triangles) std::swap(t[0], t[1]);
  EXPECT_NEAR(mass_properties(mesh).volume_m3, -8.0 / 3, 1e-15);
}

TEST(MassProperties, RefusesWhatHasNoMass) {
  EXPECT_THROW(mass_properties(Mesh()), std::invalid_argument);
  Mesh mesh = tetrahedron_mesh();
  mesh.triangles[0][0] = 4;
  EXPECT_THROW(mass_properties(mesh), std::invalid_argument);
  mesh = tetrahedron_mesh();
  mesh.vertices_m[2].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(mass_properties(mesh), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
