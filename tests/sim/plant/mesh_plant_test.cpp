#include "sim/plant/mesh_plant.h"

#include <gtest/gtest.h>

namespace cousin {
namespace {

TEST(MeshPlant, OrganKindsComeFromNames) {
  EXPECT_EQ(organ_kind_of("Leaf_03"), OrganKind::blade);
  EXPECT_EQ(organ_kind_of("leaf 3 petiole"), OrganKind::petiole);
  EXPECT_EQ(organ_kind_of("COTYLEDON"), OrganKind::cotyledon);
  EXPECT_EQ(organ_kind_of("strawberry.001"), OrganKind::fruit);
  EXPECT_EQ(organ_kind_of("Sphere.001"), OrganKind::stem);
}

TEST(MeshPlant, PartsAreOrgansWithTheirOwnVertices) {
  UserMesh user;
  user.mesh.vertices_m = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  user.mesh.triangles = {{0, 1, 2}, {0, 1, 3}, {1, 1, 2}};
  user.triangle_part = {0, 1, 1};
  user.part_names = {"stem", "leaf"};
  user.vertex_albedo = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
  MeshPlacing placing;
  placing.metres_per_unit = 0.01;
  const Plant plant = plant_of_mesh(user, placing, "mine");
  EXPECT_NO_THROW(validate(plant));
  ASSERT_EQ(plant.organs.size(), 2U);
  const Organ& leaf = plant.organs[1];
  EXPECT_EQ(leaf.kind, OrganKind::blade);
  ASSERT_EQ(leaf.surface.mesh.triangles.size(), 1U);  // the other uses a vertex twice
  ASSERT_EQ(leaf.surface.mesh.vertices_m.size(), 3U);
  EXPECT_EQ(leaf.surface.mesh.vertices_m[2], Eigen::Vector3d(0, 0, 0.01));
  EXPECT_EQ(leaf.albedo[2], (Rgbf{1, 1, 1}));
  EXPECT_NEAR(leaf_area_m2(plant), 0.5e-4, 1e-18);
}

}  // namespace
}  // namespace cousin
