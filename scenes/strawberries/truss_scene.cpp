#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/strawberries/bed_outline.h"
#include "sim/geometry/cube_sphere.h"
#include "sim/geometry/smooth_normals.h"

namespace cousin {
namespace {

/// Adds one instance of a model of its own.
Instance& add(Scene& scene, const FruitPart& part, const std::string& name,
              const std::string& category, const Pose& world_from_object) {
  Instance instance;
  instance.id = static_cast<int>(scene.instances.size());
  instance.name = name;
  instance.category = category;
  instance.model = static_cast<int>(scene.models.size());
  instance.material = static_cast<int>(scene.materials.size());
  instance.world_from_object = world_from_object;
  scene.models.push_back(part.model);
  scene.materials.push_back(part.material);
  scene.instances.push_back(std::move(instance));
  return scene.instances.back();
}

/// A stem's tube along its bent nodes, smooth between them.
FruitPart bent_tube(const Truss& truss, std::size_t index, const Material& material) {
  const BendingStem& stem = truss.plant.stems[index];
  std::vector<Eigen::Vector3d> line;
  std::vector<double> radii_m;
  const int steps = 5 * stem.segments;
  for (int i = 0; i <= steps; ++i) {
    const double share = static_cast<double>(i) / steps;
    line.push_back(bend_m(truss.plant, truss.sag.bent, static_cast<int>(index), share,
                          point_at_m(stem, share)));
    radii_m.push_back(radius_at_m(stem, share));
  }
  FruitPart part;
  part.model.name = "stem";
  part.model.mesh = tube(line, radii_m, 12);
  part.model.vertex_normals = smooth_normals(part.model.mesh);
  part.material = material;
  return part;
}

/// The swollen node at which a stem ends and others begin.
FruitPart fork_node(const Truss& truss, std::size_t index, const Material& material) {
  const BendingStem& stem = truss.plant.stems[index];
  const Eigen::Vector3d at =
      bend_m(truss.plant, truss.sag.bent, static_cast<int>(index), 1, stem.points_m.back());
  FruitPart part;
  part.model.name = "node";
  part.model.mesh = cube_sphere(6);
  for (Eigen::Vector3d& p : part.model.mesh.vertices_m) {
    part.model.vertex_normals.emplace_back(p.cast<float>());
    p = at + 1.35 * stem.radii_m.back() * p;
  }
  part.material = material;
  return part;
}

/// The bed's section drawn out along y.
FruitPart bed_part(const TrussShape& shape) {
  FruitPart part;
  ObjectModel& model = part.model;
  model.name = "bed";
  const std::vector<Eigen::Vector2d> outline = bed_outline(shape, 0.02).points_m;
  const auto count = static_cast<std::uint32_t>(outline.size());
  for (const double y : {-0.6, 0.6}) {
    for (const Eigen::Vector2d& p : outline) model.mesh.vertices_m.emplace_back(p.x(), y, p.y());
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t j = (i + 1) % count;
    model.mesh.triangles.push_back({i, i + count, j + count});
    model.mesh.triangles.push_back({i, j + count, j});
    if (i == 0 || j == 0) continue;
    model.mesh.triangles.push_back({0, i, j});
    model.mesh.triangles.push_back({count, count + j, count + i});
  }
  part.material.name = "black film";
  part.material.albedo = {0.035F, 0.035F, 0.037F};
  part.material.roughness = 0.45;
  part.material.ior = 1.5;
  return part;
}

FruitPart ground_part() {
  FruitPart part;
  part.model.name = "ground";
  part.model.mesh.vertices_m = {{-3, -3, 0}, {3, -3, 0}, {3, 3, 0}, {-3, 3, 0}};
  part.model.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  part.material.name = "soil";
  part.material.albedo = {0.16F, 0.11F, 0.075F};
  part.material.ior = 1;
  part.material.noise = NoiseTexture{{0.28F, 0.21F, 0.15F}, 0.05, 6};
  return part;
}

}  // namespace

Scene truss_scene(const Truss& truss, const std::vector<BentPlant>& frames) {
  Scene scene;
  scene.name = "strawberry_truss";
  add(scene, bed_part(truss.shape), "bed", "bed", {});
  Pose ground;
  ground.translation_m.z() = -truss.shape.bed_height_m;
  add(scene, ground_part(), "ground", "ground", ground);
  Material stalk;
  stalk.name = "strawberry stalk";
  stalk.albedo = {0.20F, 0.33F, 0.07F};
  stalk.roughness = 0.6;
  stalk.ior = 1.4;
  for (std::size_t s = 0; s < truss.plant.stems.size(); ++s) {
    add(scene, bent_tube(truss, s, stalk), "stem " + std::to_string(s), "stem", {});
    const bool forks =
        std::any_of(truss.plant.stems.begin(), truss.plant.stems.end(),
                    [&](const BendingStem& other) { return other.parent == static_cast<int>(s); });
    if (forks) add(scene, fork_node(truss, s, stalk), "node " + std::to_string(s), "stem", {});
  }
  for (std::size_t i = 0; i < truss.fruits.size(); ++i) {
    const FruitModel& fruit = truss.fruits[i];
    const Pose& at = truss.world_from_fruit[i];
    const int stem = truss.plant.loads[i].stem;
    const Pose unloaded = inverse(bent_from_unbent(truss.plant, truss.sag.bent, stem, 1)) * at;
    const std::vector<TimedPose> motion = motion_of(truss.plant, frames, stem, 1, unloaded);
    Instance& flesh =
        add(scene, fruit.flesh, "fruit " + std::to_string(i), fruit.flesh.model.name, at);
    flesh.is_specimen = true;
    flesh.mass_kg = fruit.mass_kg;
    flesh.traits = fruit.traits;
    flesh.motion = motion;
    add(scene, fruit.calyx, "calyx " + std::to_string(i), "calyx", at).motion = motion;
  }
  return scene;
}

}  // namespace cousin
