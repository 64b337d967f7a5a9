#include "sim/truth/scene_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <stdexcept>
#include <string>

namespace cousin {
namespace {

using testing::HasSubstr;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// One triangle "leaf" of material "green" under a sky.
Scene good_scene() {
  Scene scene;
  scene.name = "bed";
  ObjectModel model;
  model.name = "blade";
  model.mesh.vertices_m = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  model.mesh.triangles = {{0, 1, 2}};
  scene.models = {model};
  Material material;
  material.name = "green";
  scene.materials = {material};
  Instance instance;
  instance.id = 1;
  instance.name = "leaf 1";
  scene.instances = {instance};
  scene.lights = {Sky{}};
  scene.views = {View{}};
  return scene;
}

/// What validate says of a good scene that `spoil` has changed; empty if nothing.
std::string said(const std::function<void(Scene&)>& spoil) {
  Scene scene = good_scene();
  spoil(scene);
  try {
    validate(scene);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

std::string said_of(const Light& light) {
  return said([&](Scene& s) { s.lights.push_back(light); });
}

TEST(SceneCheck, TakesAGoodScene) {
  EXPECT_EQ(said([](Scene&) {}), "");
}

/// A specimen of id 1 and its organ of id 2.
void add_organ_of_specimen(Scene& s) {
  s.instances[0].is_specimen = true;
  Instance organ = s.instances[0];
  organ.id = 2;
  organ.name = "leaf 1, piece 1";
  organ.is_specimen = false;
  organ.part_of = 1;
  s.instances.push_back(organ);
}

TEST(SceneCheck, TakesOrgansOfASpecimenAndRefusesLinksToNothingAndChains) {
  const auto spoilt = [](const std::function<void(Scene&)>& spoil) {
    return said([&](Scene& s) {
      add_organ_of_specimen(s);
      spoil(s);
    });
  };
  EXPECT_EQ(spoilt([](Scene&) {}), "");
  EXPECT_THAT(spoilt([](Scene& s) { s.instances[1].part_of = 7; }),
              HasSubstr("\"leaf 1, piece 1\": part_of = 7 is no instance"));
  EXPECT_THAT(spoilt([](Scene& s) { s.instances[1].part_of = 2; }), HasSubstr("chains"));
  EXPECT_THAT(spoilt([](Scene& s) {
                s.instances.push_back(s.instances[1]);
                s.instances[2].id = 3;
                s.instances[2].part_of = 2;
              }),
              HasSubstr("part_of = 2 is an organ itself: links have no chains"));
  EXPECT_THAT(spoilt([](Scene& s) { s.instances[0].is_specimen = false; }),
              HasSubstr("part_of = 1 is no specimen"));
  EXPECT_THAT(spoilt([](Scene& s) { s.instances[1].is_specimen = true; }),
              HasSubstr("is an organ, and so no specimen"));
  EXPECT_THAT(spoilt([](Scene& s) {
                s.models.push_back(s.models[0]);
                s.models[1].part_names = {"blade"};
                s.instances[1].model = 1;
              }),
              HasSubstr("part_names are not those of its specimen"));
}

TEST(SceneCheck, RefusesKeypointsThatSomethingElseCarries) {
  const auto carried_by = [](const std::vector<int>& carriers) {
    return said([&](Scene& s) {
      s.models[0].keypoints = {{"base", {0, 0, 0}}, {"tip", {1, 0, 0}}};
      add_organ_of_specimen(s);
      s.instances[0].keypoint_carriers = carriers;
    });
  };
  EXPECT_EQ(carried_by({1, 2}), "");
  EXPECT_THAT(carried_by({1}), HasSubstr("keypoint_carriers.size = 1"));
  EXPECT_THAT(carried_by({1, 5}), HasSubstr("a keypoint's carrier = 5 is neither itself"));
}

TEST(SceneCheck, NamesTheModelAndItsVertex) {
  EXPECT_THAT(said([](Scene& s) { s.models[0].mesh.vertices_m[2].y() = std::nan(""); }),
              HasSubstr("scene \"bed\", model \"blade\": vertex 2"));
  EXPECT_THAT(said([](Scene& s) { s.models[0].mesh.triangles[0][1] = 3; }),
              HasSubstr("\"blade\": triangle 0"));
  EXPECT_THAT(said([](Scene& s) { s.models[0].vertex_albedo.resize(2); }),
              HasSubstr("\"blade\": vertex_albedo"));
  EXPECT_THAT(said([](Scene& s) {
                s.models[0].vertex_albedo.assign(3, {0, 2, 0});
              }),
              HasSubstr("\"blade\": vertex_albedo = 2 is not in [0, 1]"));
  EXPECT_THAT(said([](Scene& s) {
                s.models[0].vertex_normals.assign(3, {kNan, 0, 1});
              }),
              HasSubstr("\"blade\": a vertex normal"));
}

TEST(SceneCheck, TrianglesWithoutAreaAreTaken) {
  EXPECT_EQ(said([](Scene& s) { s.models[0].mesh.triangles[0] = {0, 0, 1}; }), "");
}

TEST(SceneCheck, NamesTheInstance) {
  EXPECT_THAT(said([](Scene& s) { s.instances[0].material = 1; }),
              HasSubstr("instance \"leaf 1\": no such material"));
  EXPECT_THAT(said([](Scene& s) { s.instances[0].part_materials = {0}; }),
              HasSubstr("part_materials.size = 1 is not the number of its model's parts"));
  const auto in_parts = [](Scene& s) {
    s.models[0].part_names = {"stem", "blade"};
    s.instances[0].part_materials = {0, 0};
  };
  EXPECT_EQ(said(in_parts), "");
  EXPECT_THAT(said([&](Scene& s) {
                in_parts(s);
                s.instances[0].part_materials[1] = 7;
              }),
              HasSubstr("no such part material = 7"));
  EXPECT_THAT(said([&](Scene& s) {
                in_parts(s);
                s.materials[0].kind = SurfaceKind::clear;
              }),
              HasSubstr("part material = 0 is clear"));
  EXPECT_THAT(said([&](Scene& s) {
                in_parts(s);
                s.models[0].triangle_part = {2};
              }),
              HasSubstr("no material of part = 2"));
  EXPECT_THAT(said([](Scene& s) { s.instances[0].id = -1; }), HasSubstr("\"leaf 1\": its id"));
  EXPECT_THAT(
      said([](Scene& s) { s.instances[0].world_from_object.translation_m.x() = kInfinity; }),
      HasSubstr("\"leaf 1\": its pose is not finite"));
  EXPECT_THAT(said([](Scene& s) {
                s.instances[0].motion = {{1, {}}, {1, {}}};
              }),
              HasSubstr("\"leaf 1\": its motion"));
}

TEST(SceneCheck, NamesTheMaterialItsValueAndTheLimit) {
  EXPECT_THAT(said([](Scene& s) { s.materials[0].albedo.g = -0.5F; }),
              HasSubstr("\"green\": albedo = -0.5 is not in [0, 1]"));
  EXPECT_THAT(said([](Scene& s) { s.materials[0].ior = kNan; }), HasSubstr("\"green\": ior"));
  EXPECT_THAT(said([](Scene& s) {
                s.materials[0].infrared_albedo = 0.7F;
                s.materials[0].infrared_transmittance = 0.4F;
              }),
              HasSubstr("\"green\": infrared_transmittance = 0.4"));
  EXPECT_THAT(said([](Scene& s) {
                s.materials[0].kind = SurfaceKind::glass;
                s.materials[0].ior = 1;
              }),
              HasSubstr("\"green\": ior = 1 is not in (1, 10]"));
  EXPECT_THAT(said([](Scene& s) {
                s.materials[0].kind = SurfaceKind::clear;
                s.materials[0].ior = 1;
              }),
              HasSubstr("\"green\": ior = 1 is not in (1, 10]"));
  EXPECT_THAT(said([](Scene& s) { s.materials[0].mean_free_path_m.b = -1; }),
              HasSubstr("\"green\": mean_free_path_m = -1 is not in [0, 1e6]"));
  EXPECT_THAT(said([](Scene& s) {
                s.materials[0].kind = SurfaceKind::conductor;
                s.materials[0].mean_free_path_m.r = 0.01F;
              }),
              HasSubstr("\"green\": mean_free_path_m = 0.01 needs a surface that is coated"));
}

TEST(SceneCheck, NamesTheLightByItsPlaceAndKind) {
  const Eigen::Vector3d x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  EXPECT_THAT(said_of(Lamp{z, x, 2 * x, {1, 1, 1}}),
              HasSubstr("scene \"bed\", light 1 (lamp): area between its axes, m2 = 0"));
  EXPECT_THAT(said_of(Lamp{z, x, y, {1, kInfinity, 1}}), HasSubstr("(lamp): radiance = inf"));
  EXPECT_THAT(said_of(Lamp{z, x, y, {1, kNan, 1}}), HasSubstr("(lamp): radiance = nan"));
  EXPECT_THAT(said_of(Lamp{z, x, y, {1, 1e21F, 1}}), HasSubstr("(lamp): radiance = 1e+21"));
  EXPECT_THAT(said_of(Sun{z, 1e-6, {1e20F, 1, 1}}), HasSubstr("(sun): radiance of its disk"));
  EXPECT_THAT(said_of(Sun{0 * z, 0.005, {1, 1, 1}}), HasSubstr("(sun): to_sun"));
  EXPECT_THAT(said_of(Sky{{1, 1, 1}, {-1, 0, 0}, {}}), HasSubstr("(sky): horizon = -1"));
  ClearSky clear;
  clear.turbidity = 1;
  EXPECT_THAT(said_of(clear), HasSubstr("(clear sky): turbidity = 1 is not in [1.7, 10]"));
  EXPECT_THAT(said_of(Environment{}), HasSubstr("(environment): radiance: its picture has no"));
  EXPECT_THAT(said_of(Environment{Image<Rgbf>(2, 1, {0, 0, -1})}),
              HasSubstr("(environment): radiance = -1"));
  EXPECT_THAT(said_of(Environment{Image<Rgbf>(4097, 4096)}), HasSubstr("are above 2^24"));
  Projector projector;
  projector.lens.width_px = projector.lens.height_px = 4;
  projector.lens.fx_px = projector.lens.fy_px = 4;
  projector.intensity = Image<Rgbf>(4, 3, {1, 1, 1});
  EXPECT_THAT(said_of(projector), HasSubstr("(projector): its picture and its lens"));
  projector.lens.width_px = 0;
  EXPECT_THAT(said_of(projector), HasSubstr("light 1 (projector): "));
}

TEST(SceneCheck, NamesTheView) {
  EXPECT_THAT(said([](Scene& s) { s.views[0].rig_from_world.rotation.coeffs() *= 2; }),
              HasSubstr("view 0: its pose's rotation"));
  TrueView view;
  view.frame = 3;
  view.camera.width_px = view.camera.height_px = 8;
  view.camera.fx_px = view.camera.fy_px = 8;
  view.camera.cx_px = view.camera.cy_px = 3.5;
  EXPECT_NO_THROW(validate(view));
  view.readout_s = -1;
  EXPECT_THAT([&] { validate(view); }, testing::ThrowsMessage<std::invalid_argument>(
                                           HasSubstr("view of frame 3: readout_s = -1")));
}

}  // namespace
}  // namespace cousin
