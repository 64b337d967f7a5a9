#include "scenes/seeds/setting.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sim/geometry/measure.h"

namespace cousin {
namespace {

TEST(Setting, TheBoardIsAClosedPlateWithItsPrintOnTop) {
  Scene scene;
  add_board(scene, seeds_setting(), {}, {});
  const Mesh& mesh = scene.models.at(0).mesh;
  // Faces are tessellated apart; their outlines meet where the grids agree. Volume is what the
  // outline encloses.
  EXPECT_NEAR(mass_properties(mesh).volume_m3, 0.1 * 0.1 * seeds_setting().board_thickness_m,
              1e-12);
  double top = -1;
  for (const Eigen::Vector3d& v : mesh.vertices_m) top = std::max(top, v.z());
  EXPECT_EQ(top, 0);
  EXPECT_TRUE(scene.materials.at(0).print.has_value());
}

TEST(Setting, TheScreenHoldsTheBoardTheCamerasAndLooksUp) {
  Scene scene;
  add_screen(scene, seeds_setting(), "green");
  const Mesh& mesh = scene.models.at(0).mesh;
  for (const Eigen::Vector3d& v : mesh.vertices_m)
    EXPECT_GE(v.z(), -seeds_setting().board_thickness_m - 1e-12);
  const auto& t = mesh.triangles.front();
  const Eigen::Vector3d& a = mesh.vertices_m[t[0]];
  EXPECT_GT((mesh.vertices_m[t[1]] - a).cross(mesh.vertices_m[t[2]] - a).z(), 0);
  EXPECT_GT(seeds_setting().screen_radius_m, 0.8);
}

TEST(Setting, LampsFaceTheBoard) {
  for (const char* name : {"window", "lamps", "sun"}) {
    Scene scene;
    add_lights(scene, name);
    EXPECT_FALSE(scene.lights.empty());
    for (const Light& light : scene.lights) {
      if (const auto* lamp = std::get_if<Lamp>(&light)) {
        EXPECT_LT(lamp->axis_u_m.cross(lamp->axis_v_m).dot(lamp->centre_in_world_m), 0) << name;
        EXPECT_GT(lamp->centre_in_world_m.norm(), 0.95);  // beyond the cameras
      }
    }
  }
}

TEST(Setting, AnUnknownLightListsThoseThatExist) {
  Scene scene;
  EXPECT_THROW(add_lights(scene, "candle"), std::invalid_argument);
}

TEST(Setting, TheSphereMeasures22Millimetres) {
  const SeedModel sphere = make_sphere(seeds_setting(), Rng(1));
  const double r = 0.011;
  for (const TrueTrait& t : sphere.traits) {
    // The polyhedron's chords: 0.02 % of the area and volume at 60 cells a side; lengths are exact
    // at vertices.
    if (t.name == "length") EXPECT_NEAR(t.value, 2 * r, 2e-5);
    if (t.name == "area")
      EXPECT_NEAR(t.value, 4 * std::numbers::pi * r * r, 5e-4 * 4 * std::numbers::pi * r * r);
    if (t.name == "volume")
      EXPECT_NEAR(t.value, 4.0 / 3 * std::numbers::pi * r * r * r, 5e-9 * 1.2);
  }
}

}  // namespace
}  // namespace cousin
