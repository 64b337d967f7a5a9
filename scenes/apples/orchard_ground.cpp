#include "scenes/apples/orchard_ground.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "scenes/apples/orchard_sward.h"
#include "sim/geometry/lattice.h"
#include "sim/geometry/smooth_normals.h"
#include "sim/plant/color.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

template <class T>
int append(std::vector<T>& list, T value) {
  list.push_back(std::move(value));
  return static_cast<int>(list.size()) - 1;
}

/// Soil and sward's ground as one sheet whose cells are finest near the tree.
ObjectModel ground_model(const OrchardFloor& floor) {
  const OrchardConfig& c = floor.config;
  constexpr int kCells = 260;
  constexpr double kStretch = 4.6;
  const auto place = [&](int i) {
    return c.ground.half_m * std::sinh(kStretch * (2.0 * i / kCells - 1)) / std::sinh(kStretch);
  };
  ObjectModel model;
  model.name = "ground";
  model.part_names = {"bare strip", "sward"};
  for (int j = 0; j <= kCells; ++j) {
    for (int i = 0; i <= kCells; ++i) {
      const double x = place(i), y = place(j);
      model.mesh.vertices_m.emplace_back(x, y, floor.height_m(x, y));
    }
  }
  add_lattice_triangles(model.mesh, 0, kCells, kCells);
  for (const auto& triangle : model.mesh.triangles) {
    // Both of a cell have its diagonal.
    const auto [low, high] = std::minmax_element(triangle.begin(), triangle.end());
    const Vector3d middle = 0.5 * (model.mesh.vertices_m[*low] + model.mesh.vertices_m[*high]);
    model.triangle_part.push_back(floor.alley(middle.x(), middle.y()) > 0.5 ? 1 : 0);
  }
  model.vertex_normals = smooth_normals(model.mesh);
  return model;
}

void add_trellis(Scene& scene, const OrchardConfig& c) {
  Material wire;
  wire.name = "galvanised wire";
  wire.kind = SurfaceKind::conductor;
  wire.albedo = {0.55F, 0.56F, 0.57F};
  wire.roughness = 0.5;
  Material concrete;
  concrete.name = "concrete post";
  concrete.albedo = {0.36F, 0.35F, 0.33F};
  concrete.noise = NoiseTexture{{0.24F, 0.23F, 0.21F}, 0.05, 6};
  concrete.ior = 1;
  const int steel = append(scene.materials, std::move(wire));
  const int stone = append(scene.materials, std::move(concrete));
  const auto add = [&](const CentreLine& line, const char* name, int material) {
    ObjectModel model;
    model.name = name;
    model.mesh = tube_surface(line, 10).mesh;
    model.vertex_normals = smooth_normals(model.mesh);
    const int index = append(scene.models, std::move(model));
    add_instance(scene, name, "trellis", index, material, {});
  };
  const double end = 0.9 * c.ground.half_m;
  for (const double height : c.ground.wires_m) {
    CentreLine line;
    // On the trunks' far side, a hand's breadth of slack between posts.
    for (double x = -end; x <= end; x += 0.5) {
      line.points_m.emplace_back(x, c.tree.trunk_radius_m + c.ground.wire_radius_m + 0.002, height);
      line.radii_m.push_back(c.ground.wire_radius_m);
    }
    add(line, "wire", steel);
  }
  for (double x = 0.5 * c.ground.post_m - std::floor(end / c.ground.post_m) * c.ground.post_m;
       x < end; x += c.ground.post_m) {
    const double r = c.ground.post_radius_m;
    add({{Vector3d(x, 0.1 + r, -0.1), Vector3d(x, 0.1 + r, 3.0)}, {r, r}}, "post", stone);
  }
}

/// Green, yellow and brown, on the strip and at the sward's edge.
void add_fallen_leaves(Scene& scene, const OrchardFloor& floor, const std::vector<int>& leaf_models,
                       const std::vector<int>& leaf_parts, const Rng& rng) {
  const auto& c = floor.config.ground;
  std::vector<std::vector<int>> looks;
  for (const std::vector<double>* colour : {&c.fallen_yellow, &c.fallen_brown}) {
    Material dead = scene.materials[static_cast<std::size_t>(leaf_parts.back())];
    dead.name = "fallen leaf";
    dead.albedo = to_rgb(color_vector(*colour));
    dead.back_albedo = dead.albedo;
    dead.transmittance = to_rgb(Vector3d(0.2 * color_vector(*colour)));
    dead.roughness = 0.6;
    looks.emplace_back(leaf_parts.size(), append(scene.materials, std::move(dead)));
  }
  looks.push_back(leaf_parts);
  for (int i = 0; i < c.fallen; ++i) {
    Rng own = rng.fork("fallen").fork(static_cast<std::uint64_t>(i));
    const double x = uniform(own, -3, 3), y = c.strip_m * std::clamp(0.7 * normal(own), -2.0, 2.0);
    const int leaf = leaf_models[uniform_index(own, leaf_models.size())];
    const Eigen::Quaterniond flat =
        Eigen::AngleAxisd(uniform(own, 0, 2 * kPi), Vector3d::UnitZ()) *
        Eigen::AngleAxisd(uniform(own) < 0.5 ? kPi : 0.0, Vector3d::UnitX()) *
        Eigen::AngleAxisd(0.2 * normal(own), Vector3d::UnitY());
    const double age = uniform(own);  // most are brown
    const std::vector<int>& look = looks[age < 0.25 ? 0 : age < 0.9 ? 1 : 2];
    add_instance(scene, "fallen leaf", "ground", leaf, look.front(),
                 {flat, Vector3d(x, y, floor.height_m(x, y) + 0.012)})
        .part_materials = look;
  }
}

}  // namespace

Instance& add_instance(Scene& scene, const std::string& name, const std::string& category,
                       int model, int material, const Pose& world_from_object) {
  Instance instance;
  instance.id = static_cast<int>(scene.instances.size());
  instance.name = name;
  instance.category = category;
  instance.model = model;
  instance.material = material;
  instance.world_from_object = world_from_object;
  scene.instances.push_back(std::move(instance));
  return scene.instances.back();
}

void add_orchard_ground(Scene& scene, const OrchardConfig& c, const std::vector<int>& leaf_models,
                        const std::vector<int>& leaf_parts, Rng rng) {
  const OrchardFloor floor{c, rng.fork("relief")()};
  Material soil;
  soil.name = "bare soil";
  soil.albedo = to_rgb(color_vector(c.ground.soil));
  soil.noise = NoiseTexture{to_rgb(color_vector(c.ground.soil_other)), 0.25, 9};
  soil.ior = 1;
  soil.roughness = 1;
  soil.infrared_albedo = 0.35F;
  Material sward = soil;  // thatch between blades, and what blades far away leave of their colour
  sward.name = "sward";
  const Vector3d grass = color_vector(c.ground.grass), dry = color_vector(c.ground.grass_dry);
  sward.albedo = to_rgb(Vector3d(0.70 * grass + 0.10 * dry));
  sward.noise = NoiseTexture{to_rgb(Vector3d(0.40 * grass + 0.16 * dry)), 0.5, 9};
  const int material = append(scene.materials, std::move(soil));
  append(scene.materials, std::move(sward));
  const int model = append(scene.models, ground_model(floor));
  add_instance(scene, "ground", "ground", model, material, {}).part_materials = {material,
                                                                                 material + 1};
  add_sward(scene, floor, rng.fork("sward"));
  add_trellis(scene, c);
  if (!leaf_models.empty()) add_fallen_leaves(scene, floor, leaf_models, leaf_parts, rng);
}

}  // namespace cousin
