#include "scenes/specimen/specimen_scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "sim/geometry/measure.h"
#include "sim/plant/color.h"
#include "sim/plant/mesh_plant.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

/// Rotation that takes the file's axis `up` to z.
Eigen::Matrix3d turned_up(const std::string& up) {
  Vector3d axis = Vector3d::Zero();
  axis[up.back() - 'x'] = up.front() == '-' ? -1 : 1;
  return Eigen::Quaterniond::FromTwoVectors(axis, Vector3d::UnitZ()).toRotationMatrix();
}

Eigen::AlignedBox3d box_of(const Plant& plant) {
  Eigen::AlignedBox3d box;
  for (const Organ& organ : plant.organs) {
    for (const Vector3d& vertex : organ.surface.mesh.vertices_m) box.extend(vertex);
  }
  return box;
}

/// Refuses what is no specimen; a wrong unit is why most are not.
void check_size(const SpecimenSceneConfig& config, const Vector3d& size_m) {
  const auto& limits = config.setting.limits;
  const double largest_m = size_m.maxCoeff();
  const bool is_large = largest_m > limits.largest_m;
  if (!is_large && largest_m >= limits.smallest_m) return;
  char text[160];
  std::snprintf(text, sizeof text,
                ": %.4g x %.4g x %.4g m in unit=%s; a specimen is %.4g to %.4g m", size_m.x(),
                size_m.y(), size_m.z(), config.unit.c_str(), limits.smallest_m, limits.largest_m);
  throw std::runtime_error(
      config.mesh + text +
      (is_large ? " across: if the file is in millimetres, --set unit=mm; or raise limits.largest_m"
                : " across: --set unit=..., or lower limits.smallest_m"));
}

/// Whether an organ is a sheet that lets light through.
bool is_leaf(const SpecimenSceneConfig& config, const Organ& organ, bool has_parts,
             bool is_watertight) {
  if (config.surface != "auto") return config.surface == "leaf";
  if (!has_parts) return !is_watertight;
  return organ.kind == OrganKind::blade || organ.kind == OrganKind::cotyledon;
}

constexpr double kLeafAlbedo = 0.5;  ///< of the leaf's material: half is left for what goes through

std::vector<Material> materials(const SpecimenSetting::Looks& looks) {
  Material solid;
  solid.name = "specimen";
  solid.albedo = {1, 1, 1};  // the vertices carry the colour
  Material leaf = solid;
  leaf.name = "specimen leaf";
  leaf.kind = SurfaceKind::leaf;
  const auto half = static_cast<float>(kLeafAlbedo);
  leaf.albedo = {half, half, half};
  leaf.transmittance = to_rgb(color_vector(looks.leaf_transmittance));
  leaf.infrared_transmittance = static_cast<float>(looks.infrared_transmittance);
  std::vector<Material> both = {solid, leaf};
  for (Material& material : both) {
    material.ior = looks.ior;
    material.roughness = looks.roughness;
    material.infrared_albedo = static_cast<float>(looks.infrared_albedo);
  }
  return both;
}

/// Vertices take shares of their material's albedo.
void colour(Organ& organ, bool leaf, const SpecimenSetting::Looks& looks) {
  organ.look = leaf ? 1 : 0;
  if (organ.albedo.empty()) {
    organ.albedo.assign(organ.surface.mesh.vertices_m.size(), to_rgb(color_vector(looks.albedo)));
  }
  if (!leaf) return;
  for (Rgbf& c : organ.albedo) {
    const auto share = [](float v) { return std::min(1.0F, v / static_cast<float>(kLeafAlbedo)); };
    c = {share(c.r), share(c.g), share(c.b)};
  }
}

/// What the whole mesh is: corners that are equal are one, as files repeat them on seams.
struct Whole {
  Mesh mesh;
  MeshCheck check;
};

Whole whole_of(const Plant& plant) {
  std::vector<Mesh> meshes;
  for (const Organ& organ : plant.organs) meshes.push_back(organ.surface.mesh);
  Whole whole;
  whole.mesh = weld(merged(meshes));
  whole.check = check_watertight(whole.mesh);
  return whole;
}

std::vector<TrueTrait> traits_of(const Plant& plant, const Whole& whole, const Vector3d& size_m,
                                 double density_kg_m3) {
  double leaf_m2 = 0;
  for (const Organ& organ : plant.organs) {
    if (organ.look == 1) leaf_m2 += surface_area_m2(organ.surface.mesh);
  }
  std::vector<TrueTrait> traits = {
      {"height", "m", size_m.z()},
      {"width_x", "m", size_m.x()},
      {"width_y", "m", size_m.y()},
      {"area", "m2", surface_area_m2(whole.mesh)},
      {"watertight", "1", whole.check.ok ? 1.0 : 0.0},
      {"open_edges", "1", static_cast<double>(whole.check.open_edges)},
      {"degenerate_triangles", "1", static_cast<double>(whole.check.degenerate_triangles)}};
  if (leaf_m2 > 0) traits.push_back({"leaf_area", "m2", leaf_m2});
  if (whole.check.ok) {
    const double volume_m3 = mass_properties(whole.mesh).volume_m3;
    traits.push_back({"volume", "m3", volume_m3});
    traits.push_back({"mass", "kg", density_kg_m3 * volume_m3});
  }
  return traits;
}

void add_table(Scene& scene, const SpecimenSetting::Table& table, double size_m) {
  constexpr int kSides = 96;
  const double radius_m = std::max(0.5, table.radius_share * size_m);
  ObjectModel model;
  model.name = "table";
  model.mesh.vertices_m.emplace_back(0, 0, 0);
  for (int k = 0; k < kSides; ++k) {
    const double angle = 2 * kPi * k / kSides;
    model.mesh.vertices_m.emplace_back(radius_m * std::cos(angle), radius_m * std::sin(angle), 0);
    const auto next = static_cast<std::uint32_t>(1 + (k + 1) % kSides);
    model.mesh.triangles.push_back({0, static_cast<std::uint32_t>(1 + k), next});
  }
  Material material;
  material.name = "table";
  material.albedo = to_rgb(color_vector(table.albedo));
  material.noise = NoiseTexture{to_rgb(color_vector(table.other_albedo)), table.noise_m, 6};
  material.ior = 1;
  material.roughness = 1;
  Instance instance;
  instance.id = 0;
  instance.name = instance.category = "table";
  scene.models.push_back(std::move(model));
  scene.materials.push_back(std::move(material));
  scene.instances.push_back(std::move(instance));
}

void add_light(Scene& scene, const SpecimenSetting& setting, const std::string& light) {
  const auto& c = setting.light;
  if (light == "sun") {
    ClearSky sky;
    const double e = c.sun_elevation_rad, a = c.sun_azimuth_rad;
    sky.to_sun = {std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)};
    sky.turbidity = c.turbidity;
    sky.scale = 0.02;
    sky.ground_albedo = to_rgb(color_vector(setting.table.albedo));
    scene.lights.emplace_back(sky);
    return;
  }
  const Vector3d zenith = color_vector(c.overcast);
  scene.lights.emplace_back(
      Sky{to_rgb(zenith), to_rgb(Vector3d(zenith / 3)), to_rgb(Vector3d(0.1 * zenith))});
}

/// All around, each view in a stratum of the azimuths.
std::vector<View> views_of(const SpecimenSceneConfig& config, const Vector3d& size_m, Rng rng) {
  std::vector<View> views;
  const Vector3d aim_m(0, 0, 0.5 * size_m.z());
  for (int i = 0; i < config.views; ++i) {
    Rng own = rng.fork(static_cast<std::uint64_t>(i));
    const double azimuth = 2 * kPi * (i + uniform(own)) / config.views;
    const double pitch = uniform(own, config.pitch_min_rad, config.pitch_max_rad);
    const double distance_m =
        size_m.norm() * uniform(own, config.distance_min, config.distance_max);
    Vector3d eye_m =
        aim_m + distance_m * Vector3d(std::cos(pitch) * std::cos(azimuth),
                                      std::cos(pitch) * std::sin(azimuth), std::sin(pitch));
    eye_m.z() = std::max(eye_m.z(), 0.02 * distance_m);  // above the table
    View view;
    view.time_s = i;
    view.rig_from_world = view.rig_from_world_end = look_at(eye_m, aim_m);
    view.focus_in_world_m = aim_m;
    views.push_back(view);
  }
  return views;
}

}  // namespace

Scene build_specimen_scene(const SpecimenSceneConfig& config, const UserMesh& user, Rng rng) {
  validate(config);
  if (user.is_in_metres && config.unit != "m") {
    throw std::invalid_argument("unit = " + config.unit + ", but " + config.mesh +
                                " is a glTF file, whose numbers are metres; leave unit out");
  }
  MeshPlacing placing;
  placing.metres_per_unit = user.is_in_metres ? 1 : metres_per_unit(config.unit);
  placing.ours_from_file = turned_up(config.up);
  Plant plant = plant_of_mesh(user, placing, config.name);
  const Eigen::AlignedBox3d box = box_of(plant);
  if (box.isEmpty()) throw std::runtime_error(config.mesh + ": there are no triangles");
  check_size(config, box.sizes());
  const Vector3d foot_m(box.center().x(), box.center().y(), box.min().z());
  for (Organ& organ : plant.organs) {
    for (Vector3d& vertex : organ.surface.mesh.vertices_m) vertex -= foot_m;
  }
  const Whole whole = whole_of(plant);
  if (config.needs_volume && !whole.check.ok) {
    throw std::runtime_error(config.mesh + ": has no volume: " + whole.check.problem +
                             " (needs_volume is set)");
  }
  for (Organ& organ : plant.organs)
    colour(organ, is_leaf(config, organ, !user.triangle_part.empty(), whole.check.ok),
           config.setting.looks);

  Scene scene;
  scene.name = "specimen";
  scene.rig = config.rig;
  add_light(scene, config.setting, config.light);
  add_table(scene, config.setting.table, box.sizes().norm());
  PlantModel made = plant_model(plant);
  Instance instance;
  instance.id = 1;
  instance.name = instance.category = config.name;
  instance.is_specimen = true;
  instance.model = static_cast<int>(scene.models.size());
  const int first = static_cast<int>(scene.materials.size());
  instance.material = first + plant.organs.front().look;
  for (const int look : made.part_looks) instance.part_materials.push_back(first + look);
  instance.traits = traits_of(plant, whole, box.sizes(), config.setting.looks.density_kg_m3);
  for (const TrueTrait& trait : instance.traits)
    if (trait.name == "mass") instance.mass_kg = trait.value;
  for (Material& material : materials(config.setting.looks))
    scene.materials.push_back(std::move(material));
  scene.models.push_back(std::move(made.model));
  scene.instances.push_back(std::move(instance));
  scene.views = views_of(config, box.sizes(), rng.fork("views"));
  validate(scene);
  return scene;
}

}  // namespace cousin
