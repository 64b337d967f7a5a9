#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "sim/geometry/measure.h"
#include "tests/sim/geometry/solids.h"

namespace cousin {
namespace {

using ::testing::HasSubstr;

TEST(CheckWatertight, ClosedSolidsAreOk) {
  for (const Mesh& mesh : {box_mesh({1, 2, 3}), tetrahedron_mesh(), ellipsoid_mesh({3, 2, 1}, 3)}) {
    const MeshCheck check = check_watertight(mesh);
    EXPECT_TRUE(check.ok) << check.problem;
    EXPECT_EQ(check.open_edges, 0);
    EXPECT_EQ(check.degenerate_triangles, 0);
  }
}

TEST(CheckWatertight, AHoleIsNamed) {
  Mesh mesh = box_mesh({1, 2, 3});
  mesh.triangles.pop_back();
  const MeshCheck check = check_watertight(mesh);
  EXPECT_FALSE(check.ok);
  EXPECT_EQ(check.open_edges, 3);
  EXPECT_THAT(check.problem, HasSubstr("belongs to 1 triangle; a closed mesh needs 2"));
}

TEST(CheckWatertight, AFlippedTriangleIsNamed) {
  Mesh mesh = box_mesh({1, 2, 3});
  std::swap(mesh.triangles[5][0], mesh.triangles[5][1]);
  EXPECT_THAT(check_watertight(mesh).problem, HasSubstr("opposite orientations"));
}

TEST(CheckWatertight, InsideOutIsNamed) {
  Mesh mesh = tetrahedron_mesh();
  for (auto& t : mesh.triangles) std::swap(t[0], t[1]);
  EXPECT_THAT(check_watertight(mesh).problem, HasSubstr("inside out"));
}

TEST(CheckWatertight, ThreeTrianglesAtAnEdgeAreNamed) {
  Mesh mesh = tetrahedron_mesh();
  mesh.vertices_m.emplace_back(5, 5, 5);
  mesh.triangles.push_back({0, 1, 4});
  EXPECT_THAT(check_watertight(mesh).problem, HasSubstr("edge 0-1 belongs to 3 triangles"));
}

TEST(CheckWatertight, BadNumbersAreNamed) {
  EXPECT_THAT(check_watertight(Mesh()).problem, HasSubstr("no triangles"));
  Mesh mesh = tetrahedron_mesh();
  mesh.vertices_m[3].y() = std::numeric_limits<double>::infinity();
  EXPECT_THAT(check_watertight(mesh).problem, HasSubstr("vertex 3 is not finite"));
  mesh = tetrahedron_mesh();
  mesh.triangles[2][1] = 99;
  EXPECT_THAT(check_watertight(mesh).problem, HasSubstr("triangle 2 names vertex 99; there are 4"));
  mesh = tetrahedron_mesh();
  mesh.triangles[1][1] = mesh.triangles[1][0];
  const MeshCheck check = check_watertight(mesh);
  EXPECT_THAT(check.problem, HasSubstr("triangle 1 uses a vertex twice"));
  EXPECT_EQ(check.degenerate_triangles, 1);
}

TEST(Weld, RepeatedVerticesBecomeOne) {
  const Mesh closed = ellipsoid_mesh({3, 2, 1}, 2);
  Mesh soup;
  for (const auto& t : closed.triangles) {
    const auto first = static_cast<std::uint32_t>(soup.vertices_m.size());
    for (const std::uint32_t v : t) soup.vertices_m.push_back(closed.vertices_m[v]);
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  EXPECT_FALSE(check_watertight(soup).ok);
  const Mesh welded = weld(soup);
  EXPECT_EQ(welded.vertices_m.size(), closed.vertices_m.size());
  EXPECT_TRUE(check_watertight(welded).ok);
}

TEST(Weld, MinusZeroIsZeroAndCollapsedTrianglesGo) {
  const Mesh mesh{{{0, 0, 0}, {-0.0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {1, 2, 3}}};
  const Mesh welded = weld(mesh);
  EXPECT_EQ(welded.vertices_m.size(), 3U);
  EXPECT_EQ(welded.triangles.size(), 1U);
}

}  // namespace
}  // namespace cousin
