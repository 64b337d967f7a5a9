#include "benchmarks/suites/shapes/shape_meshes.h"

#include <gtest/gtest.h>

#include <set>

#include "scenes/seeds/mesh_variation.h"
#include "sim/geometry/measure.h"

namespace cousin {
namespace {

TEST(ShapeMeshes, EachIsAClosedBodyTheSizeOfASeed) {
  std::set<double> volumes;
  for (const std::string_view name : shape_names()) {
    const Mesh mesh = shape_mesh(name);
    EXPECT_TRUE(check_watertight(mesh).ok) << name << ": " << check_watertight(mesh).problem;
    const OrientedBox box = minimum_volume_box(mesh.vertices_m);
    EXPECT_GT(box.size_m.z(), 0.002) << name;
    EXPECT_LT(box.size_m.x(), 0.015) << name;
    volumes.insert(mass_properties(mesh).volume_m3);
  }
  EXPECT_EQ(volumes.size(), shape_names().size());
  EXPECT_THROW(shape_mesh("brick"), std::invalid_argument);
}

TEST(MeshVariation, EveryOneIsClosedAndOfAnotherSize) {
  const Mesh mesh = shape_mesh("bean");
  EXPECT_EQ(varied_mesh(mesh, 0, Rng(1)).vertices_m, mesh.vertices_m);
  std::set<double> lengths;
  for (std::uint64_t i = 0; i < 8; ++i) {
    const Mesh varied = varied_mesh(mesh, 0.3, Rng(i));
    EXPECT_TRUE(check_watertight(varied).ok);
    EXPECT_GT(mass_properties(varied).volume_m3, 0);
    lengths.insert(minimum_volume_box(varied.vertices_m).size_m.x());
  }
  EXPECT_EQ(lengths.size(), 8U);
  EXPECT_GT(*lengths.rbegin() / *lengths.begin(), 1.1);
}

TEST(MeshVariation, AFactorOfEightPerCentChangesLengthsByAboutThat) {
  const Mesh mesh = shape_mesh("pea");
  const double radius_m = std::cbrt(mass_properties(mesh).volume_m3);
  double squares = 0;
  constexpr int kMeshes = 60;
  for (std::uint64_t i = 0; i < kMeshes; ++i) {
    const double change =
        std::log(std::cbrt(mass_properties(varied_mesh(mesh, 0.08, Rng(i))).volume_m3) / radius_m);
    squares += change * change / kMeshes;
  }
  // The mean of three factors has a deviation of 0.08 / sqrt(3); waves add to it.
  EXPECT_NEAR(std::sqrt(squares), 0.08 / std::sqrt(3.0), 0.02);
}

}  // namespace
}  // namespace cousin
