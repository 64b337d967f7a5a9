#include "sim/render/cycles/plain_scene.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/render/value_noise.h"

namespace cousin {
namespace {

/// A printed plate of 20 x 10 mm, 1 mm thick.
Scene printed_plate() {
  Scene scene;
  ObjectModel plate{.name = "plate"};
  for (const double z : {-0.001, 0.0}) {
    for (const auto& [x, y] :
         {std::pair{-0.01, -0.005}, {0.01, -0.005}, {0.01, 0.005}, {-0.01, 0.005}})
      plate.mesh.vertices_m.emplace_back(x, y, z);
  }
  plate.mesh.triangles = {{4, 5, 6}, {4, 6, 7}, {0, 2, 1}, {0, 3, 2}};
  scene.models = {plate};
  Material paper{.name = "paper", .albedo = {0.8F, 0.8F, 0.8F}};
  SeedBoard board;
  board.has_markers = false;
  paper.print = board;
  paper.ink_albedo = {0.04F, 0.04F, 0.04F};
  Material rough{.name = "soil"};
  rough.noise = NoiseTexture{};
  scene.materials = {paper, rough};
  Instance printed{.id = 1, .name = "board"};
  Instance plain{.id = 2, .name = "ground"};
  plain.material = 1;
  scene.instances = {printed, plain};
  scene.lights.emplace_back(Sky{{1, 1, 1}, {1, 1, 1}, {0, 0, 0}});
  Projector projector;
  projector.lens = {LensModel::pinhole, 8, 8, 10, 10, 3.5, 3.5, {}, {}};
  projector.intensity = Image<Rgbf>(8, 8, {1, 1, 1});
  scene.lights.emplace_back(projector);
  return scene;
}

TrueView lens_view() {
  TrueView view;
  view.camera = Camera{LensModel::opencv5, 64, 48, 60, 60, 31.5, 23.5, {0.1}};
  return view;
}

TEST(PlainScene, APrintBecomesVertexColoursOfTheSameAreas) {
  const PlainScene plain = plain_scene(printed_plate(), lens_view(), 0.0005);
  ASSERT_EQ(plain.scene.models.size(), 3U);  // what both shared, with noise, with the print
  EXPECT_EQ(plain.scene.instances[0].model, 2);
  EXPECT_EQ(plain.scene.instances[1].model, 1);
  const ObjectModel& board = plain.scene.models[2];
  ASSERT_EQ(board.vertex_albedo.size(), board.mesh.vertices_m.size());
  double ink_m2 = 0, face_m2 = 0;
  for (const auto& t : board.mesh.triangles) {
    const auto& a = board.mesh.vertices_m[t[0]];
    const Eigen::Vector3d normal =
        (board.mesh.vertices_m[t[1]] - a).cross(board.mesh.vertices_m[t[2]] - a);
    if (std::abs(a.z()) > 1e-9) continue;
    EXPECT_GT(normal.z(), 0);  // faces up as the plate's face did
    face_m2 += 0.5 * normal.norm();
    if (board.vertex_albedo[t[0]].r < 0.5F) {
      EXPECT_FLOAT_EQ(board.vertex_albedo[t[0]].r, 0.05F);  // of 0.8: the ink's 0.04
      ink_m2 += 0.5 * normal.norm();
    }
  }
  EXPECT_NEAR(face_m2, 0.02 * 0.01, 1e-12);
  // Black squares of 6 mm about the middle, from the board's rule on a fine grid; cells of half a
  // millimetre divide 6 mm, so only rounding is left.
  SeedBoard rule;
  rule.has_markers = false;
  int black = 0;
  for (int j = 0; j < 200; ++j) {
    for (int i = 0; i < 400; ++i)
      black += is_black(rule, -0.01 + (i + 0.5) * 5e-5, -0.005 + (j + 0.5) * 5e-5) ? 1 : 0;
  }
  EXPECT_NEAR(ink_m2, black * 25e-10, 1e-9);
}

TEST(PlainScene, NoiseBecomesTheColoursOfVerticesThatTheRenderersHave) {
  Scene scene = printed_plate();
  Material& soil = scene.materials[1];
  soil.albedo = {0.4F, 0.2F, 0.1F};
  soil.noise = NoiseTexture{{0.1F, 0.3F, 0.1F}, 0.01, 3};
  const PlainScene plain = plain_scene(scene, lens_view());
  const Instance& ground = plain.scene.instances[1];
  const ObjectModel& model = plain.scene.models[static_cast<std::size_t>(ground.model)];
  const Material& material = plain.scene.materials[static_cast<std::size_t>(ground.material)];
  ASSERT_EQ(model.vertex_albedo.size(), model.mesh.vertices_m.size());
  double area_m2 = 0, longest_m = 0;
  for (const auto& t : model.mesh.triangles) {
    const auto& v = model.mesh.vertices_m;
    area_m2 += 0.5 * (v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]).norm();
    for (std::size_t k = 0; k < 3; ++k)
      longest_m = std::max(longest_m, (v[t[k]] - v[t[(k + 1) % 3]]).norm());
  }
  EXPECT_NEAR(area_m2, 2 * 0.02 * 0.01, 1e-12);  // cut, and nothing lost
  EXPECT_LE(longest_m, 0.5 * 0.01 / 4 + 1e-9);   // half of the third octave's features
  for (std::size_t i = 0; i < model.mesh.vertices_m.size(); ++i) {
    const float share = value_noise(model.mesh.vertices_m[i].cast<float>() / 0.01F, 3);
    EXPECT_NEAR(material.albedo.r * model.vertex_albedo[i].r, 0.4F - 0.3F * share, 1e-6F);
    EXPECT_NEAR(material.albedo.g * model.vertex_albedo[i].g, 0.2F + 0.1F * share, 1e-6F);
  }
}

TEST(PlainScene, PartsOfOtherMaterialsBecomeInstances) {
  Scene scene = printed_plate();
  scene.models[0].part_names = {"face", "back"};
  scene.models[0].triangle_part = {0, 0, 1, 1};
  scene.instances[1].part_materials = {1, 1};  // one material: one instance
  Instance both{.id = 5, .name = "plant"};
  both.part_materials = {1, 0};
  scene.instances.push_back(both);
  const PlainScene plain = plain_scene(scene, lens_view());
  ASSERT_EQ(plain.scene.instances.size(), 4U);
  EXPECT_NO_THROW(validate(plain.scene));
  double soil_m2 = 0;
  for (const Instance& instance : plain.scene.instances) {
    EXPECT_TRUE(instance.part_materials.empty());
    const bool is_soil =
        plain.scene.materials[static_cast<std::size_t>(instance.material)].name == "soil";
    if (instance.name != "plant" || !is_soil) continue;
    const Mesh& mesh = plain.scene.models[static_cast<std::size_t>(instance.model)].mesh;
    for (const auto& [a, b, c] : mesh.triangles) {
      const Eigen::Vector3d& from = mesh.vertices_m[a];
      soil_m2 += 0.5 * (mesh.vertices_m[b] - from).cross(mesh.vertices_m[c] - from).norm();
    }
  }
  EXPECT_NEAR(soil_m2, 0.02 * 0.01, 1e-12);  // one of the plate's two faces
}

TEST(PlainScene, WhatCannotBeSaidIsLeftOutAndNamed) {
  const PlainScene plain = plain_scene(printed_plate(), lens_view());
  EXPECT_EQ(plain.changes.size(), 4U);  // print, noise, projector, lens
  EXPECT_EQ(plain.scene.lights.size(), 1U);
  EXPECT_EQ(plain.view.camera.model, LensModel::pinhole);
  EXPECT_NO_THROW(validate(plain.view.camera));
  for (const Material& material : plain.scene.materials)
    EXPECT_FALSE(material.print || material.noise || material.back_albedo);
  EXPECT_THROW(plain_scene(printed_plate(), lens_view(), 0), std::invalid_argument);
  EXPECT_THROW(plain_scene(printed_plate(), lens_view(), 1e-7), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
