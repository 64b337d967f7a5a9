#include "scenes/specimen/specimen_scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <stdexcept>

namespace cousin {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

/// A box of 20 x 30 x 100 units about (7, 7, 7).
UserMesh box() {
  UserMesh user;
  for (int i = 0; i < 8; ++i)
    user.mesh.vertices_m.emplace_back(7 + (i & 1 ? 10 : -10), 7 + (i & 2 ? 15 : -15),
                                      7 + (i & 4 ? 50 : -50));
  user.mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                         {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return user;
}

SpecimenSceneConfig in_millimetres() {
  SpecimenSceneConfig config;
  config.mesh = "mine.ply";
  config.unit = "mm";
  return config;
}

const Instance& specimen_of(const Scene& scene) { return scene.instances.back(); }

std::map<std::string, double> traits_of(const Scene& scene) {
  std::map<std::string, double> traits;
  for (const TrueTrait& trait : specimen_of(scene).traits) traits[trait.name] = trait.value;
  return traits;
}

std::string error_of(const SpecimenSceneConfig& config, const UserMesh& user) {
  try {
    build_specimen_scene(config, user, Rng(1));
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST(SpecimenScene, AUnitForAFileThatHasItsOwnIsRefused) {
  UserMesh user = box();
  user.is_in_metres = true;
  SpecimenSceneConfig config = in_millimetres();
  config.mesh = "mine.glb";
  try {
    build_specimen_scene(config, user, Rng(1));
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(),
                AllOf(HasSubstr("unit = mm"), HasSubstr("mine.glb"), HasSubstr("metres")));
  }
}

TEST(SpecimenScene, AMeshTurnedInsideOutIsNamedAsThat) {
  UserMesh user = box();
  for (auto& t : user.mesh.triangles) std::swap(t[1], t[2]);
  SpecimenSceneConfig config = in_millimetres();
  config.needs_volume = true;
  EXPECT_THAT(error_of(config, user),
              AllOf(HasSubstr("mine.ply"), HasSubstr("inside out"), HasSubstr("-6e-05 m3")));
}

TEST(SpecimenScene, AClosedMeshStandsOnTheTableWithItsVolume) {
  const Scene scene = build_specimen_scene(in_millimetres(), box(), Rng(1));
  EXPECT_NO_THROW(validate(scene));
  const auto traits = traits_of(scene);
  EXPECT_NEAR(traits.at("height"), 0.1, 1e-12);
  EXPECT_NEAR(traits.at("width_x"), 0.02, 1e-12);
  EXPECT_NEAR(traits.at("width_y"), 0.03, 1e-12);
  EXPECT_NEAR(traits.at("area"), 2 * (0.02 * 0.03 + 0.02 * 0.1 + 0.03 * 0.1), 1e-12);
  EXPECT_NEAR(traits.at("volume"), 0.02 * 0.03 * 0.1, 1e-15);
  EXPECT_NEAR(traits.at("mass"), 950 * 0.02 * 0.03 * 0.1, 1e-12);
  EXPECT_EQ(traits.at("watertight"), 1);
  EXPECT_FALSE(traits.contains("leaf_area"));
  const Mesh mesh = mesh_in_world(scene, specimen_of(scene));
  for (const Eigen::Vector3d& v : mesh.vertices_m) {
    EXPECT_NEAR(std::abs(v.x()), 0.01, 1e-12);
    EXPECT_TRUE(std::abs(v.z()) < 1e-12 || std::abs(v.z() - 0.1) < 1e-12);
  }
}

TEST(SpecimenScene, AMeshOfAnotherUnitIsRefusedWithItsSizeAndTheRemedy) {
  SpecimenSceneConfig config = in_millimetres();
  config.unit = "m";
  EXPECT_THAT(error_of(config, box()),
              AllOf(HasSubstr("mine.ply"), HasSubstr("20 x 30 x 100 m"), HasSubstr("unit=mm")));
  config.unit = "um";
  EXPECT_THAT(error_of(config, box()), HasSubstr("limits.smallest_m"));
  UserMesh metres = box();
  metres.is_in_metres = true;
  config.unit = "m";
  EXPECT_THAT(error_of(config, metres), HasSubstr("20 x 30 x 100 m"));
}

TEST(SpecimenScene, AMeshWithAHoleHasNoVolumeAndSaysSo) {
  UserMesh open = box();
  open.mesh.triangles.pop_back();
  const auto traits = traits_of(build_specimen_scene(in_millimetres(), open, Rng(1)));
  EXPECT_EQ(traits.at("watertight"), 0);
  EXPECT_EQ(traits.at("open_edges"), 3);
  EXPECT_FALSE(traits.contains("volume"));
  EXPECT_TRUE(traits.contains("leaf_area"));  // an open mesh without parts is taken for sheets
  SpecimenSceneConfig config = in_millimetres();
  config.needs_volume = true;
  EXPECT_THAT(
      error_of(config, open),
      AllOf(HasSubstr("mine.ply"), HasSubstr("belongs to 1 triangle"), HasSubstr("needs_volume")));
}

TEST(SpecimenScene, CornersThatAFileRepeatsAreStillClosed) {
  UserMesh split = box();
  UserMesh repeated;
  for (const auto& t : split.mesh.triangles) {
    const auto n = static_cast<std::uint32_t>(repeated.mesh.vertices_m.size());
    for (const std::uint32_t v : t) repeated.mesh.vertices_m.push_back(split.mesh.vertices_m[v]);
    repeated.mesh.triangles.push_back({n, n + 1, n + 2});
  }
  EXPECT_EQ(traits_of(build_specimen_scene(in_millimetres(), repeated, Rng(1))).at("watertight"),
            1);
}

TEST(SpecimenScene, UpIsAnyAxisOfTheFileAndColoursAreKept) {
  SpecimenSceneConfig config = in_millimetres();
  UserMesh user = box();
  user.vertex_albedo.assign(8, {0.25F, 0.5F, 0.125F});
  const double heights_m[] = {0.02, 0.03, 0.1, 0.02, 0.03, 0.1};
  int i = 0;
  for (const char* up : {"x", "y", "z", "-x", "-y", "-z"}) {
    config.up = up;
    const Scene scene = build_specimen_scene(config, user, Rng(1));
    EXPECT_NEAR(traits_of(scene).at("height"), heights_m[i++], 1e-12) << up;
    EXPECT_NEAR(traits_of(scene).at("volume"), 6e-5, 1e-15) << up;  // never mirrored
    const auto& model = scene.models[static_cast<std::size_t>(specimen_of(scene).model)];
    EXPECT_EQ(model.vertex_albedo[0], (Rgbf{0.25F, 0.5F, 0.125F}));
  }
}

TEST(SpecimenScene, RefusesWordsThatItDoesNotKnow) {
  const auto refuses = [](auto change) {
    SpecimenSceneConfig config = in_millimetres();
    change(config);
    EXPECT_THROW(validate(config), std::invalid_argument);
  };
  refuses([](auto& c) { c.unit = "furlong"; });
  refuses([](auto& c) { c.up = "w"; });
  refuses([](auto& c) { c.surface = "glass"; });
  refuses([](auto& c) { c.light = "moon"; });
  refuses([](auto& c) { c.name = ""; });
  refuses([](auto& c) { c.name = std::string(257, 'x'); });
  refuses([](auto& c) { c.views = 0; });
  refuses([](auto& c) { c.distance_min = 5; });
  refuses([](auto& c) { c.setting.limits.largest_m = 1e-5; });
}

}  // namespace
}  // namespace cousin
