#include "scenes/apples/orchard_ground.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/geometry/gradient_noise.h"
#include "sim/geometry/lattice.h"
#include "sim/geometry/smooth_normals.h"
#include "sim/plant/color.h"

namespace cousin {
namespace {

using Eigen::Vector3d;
constexpr double kPi = std::numbers::pi;

template <class T>
int append(std::vector<T>& list, T value) {
  list.push_back(std::move(value));
  return static_cast<int>(list.size()) - 1;
}

/// 0 on the bare strips below the rows, 1 in the alleys.
double in_alley(const OrchardConfig& c, double x, double y, std::uint64_t key) {
  const double off = std::abs(y - c.tree.row_m * std::round(y / c.tree.row_m));
  const double edge = c.ground.strip_m * (1 + 0.25 * noise3({x / 0.35, y / 0.35, 0.5}, key));
  return smoothstep(edge - 0.06, edge + 0.06, off);
}

double height_at(const OrchardConfig& c, double x, double y, std::uint64_t key) {
  const double clods = fractal_noise3({x / 0.11, y / 0.11, 0.3}, 4, key);
  const double swells = noise3({x / 1.3, y / 1.3, 0.8}, key + 1);
  // Trees stand on a low ridge.
  const double off = std::abs(y - c.tree.row_m * std::round(y / c.tree.row_m));
  return 0.010 * clods + 0.02 * swells + 0.05 * std::exp(-std::pow(off / 0.6, 2)) - 0.05;
}

/// Soil and sward's ground as one sheet whose cells are finest near the tree.
ObjectModel ground_model(const OrchardConfig& c, std::uint64_t key) {
  constexpr int kCells = 260;
  constexpr double kStretch = 3.2;
  const auto place = [&](int i) {
    return c.ground.half_m * std::sinh(kStretch * (2.0 * i / kCells - 1)) / std::sinh(kStretch);
  };
  ObjectModel model;
  model.name = "ground";
  model.part_names = {"bare strip", "sward"};
  for (int j = 0; j <= kCells; ++j) {
    for (int i = 0; i <= kCells; ++i) {
      const double x = place(i), y = place(j);
      model.mesh.vertices_m.emplace_back(x, y, height_at(c, x, y, key));
    }
  }
  add_lattice_triangles(model.mesh, 0, kCells, kCells);
  for (const auto& triangle : model.mesh.triangles) {
    // Both of a cell have its diagonal.
    const auto [low, high] = std::minmax_element(triangle.begin(), triangle.end());
    const Vector3d middle = 0.5 * (model.mesh.vertices_m[*low] + model.mesh.vertices_m[*high]);
    model.triangle_part.push_back(in_alley(c, middle.x(), middle.y(), key + 4) > 0.5 ? 1 : 0);
  }
  model.vertex_normals = smooth_normals(model.mesh);
  return model;
}

/// A square of sward: blades that bend over, some dry, a few broad leaves of weeds.
ObjectModel sward_model(const OrchardConfig& c, Rng rng) {
  ObjectModel model;
  model.name = "sward";
  const Vector3d fresh = color_vector(c.ground.grass), dry = color_vector(c.ground.grass_dry);
  const Vector3d base = fresh.cwiseMax(dry);
  const double half = 0.55 * c.ground.patch_m;
  for (int b = 0; b < c.ground.blades; ++b) {
    Rng own = rng.fork(static_cast<std::uint64_t>(b));
    const Vector3d foot(uniform(own, -half, half), uniform(own, -half, half), -0.012);
    const double azimuth = uniform(own, 0, 2 * kPi),
                 length = c.ground.grass_m * uniform(own, 0.5, 1.5);
    const Vector3d out(std::cos(azimuth), std::sin(azimuth), 0), side(-out.y(), out.x(), 0);
    const double lean = uniform(own, 0.1, 0.9), bow = uniform(own, 0.3, 1.3);
    const double width = uniform(own, 0.0012, 0.0028);
    const bool is_dry = uniform(own) < 0.13;
    const double tone = uniform(own, 0.7, 1.15);
    const auto first = static_cast<std::uint32_t>(model.mesh.vertices_m.size());
    constexpr std::uint32_t kSteps = 4;
    Vector3d at = foot;
    for (std::uint32_t k = 0; k <= kSteps; ++k) {
      const double t = static_cast<double>(k) / kSteps, angle = lean + bow * t;
      const double w = 0.5 * width * (1 - t * t);
      model.mesh.vertices_m.emplace_back(at - std::max(w, 5e-5) * side);
      model.mesh.vertices_m.emplace_back(at + std::max(w, 5e-5) * side);
      const Vector3d colour =
          tone * (is_dry ? dry : Vector3d(fresh + 0.25 * (1 - t) * (dry - fresh)));
      const Rgbf share = to_rgb(colour.cwiseQuotient(base).cwiseMin(1.0));
      model.vertex_albedo.insert(model.vertex_albedo.end(), {share, share});
      at += length / kSteps * (std::sin(angle) * out + std::cos(angle) * Vector3d::UnitZ());
      if (k == 0) continue;
      const std::uint32_t a = first + 2 * (k - 1);
      model.mesh.triangles.push_back({a, a + 1, a + 3});
      model.mesh.triangles.push_back({a, a + 3, a + 2});
    }
  }
  return model;
}

void add_sward(Scene& scene, const OrchardConfig& c, std::uint64_t key, Rng rng) {
  Material blades;
  blades.name = "grass";
  blades.kind = SurfaceKind::leaf;
  blades.albedo =
      to_rgb(Vector3d(color_vector(c.ground.grass).cwiseMax(color_vector(c.ground.grass_dry))));
  blades.transmittance = to_rgb(Vector3d(0.6 * color_vector(c.ground.grass)));
  blades.roughness = 0.5;
  blades.ior = 1.45;
  blades.infrared_albedo = 0.45F;
  blades.infrared_transmittance = 0.4F;
  const int material = append(scene.materials, std::move(blades));
  constexpr int kVariants = 3;
  const int first = static_cast<int>(scene.models.size());
  for (int v = 0; v < kVariants; ++v)
    scene.models.push_back(sward_model(c, rng.fork("patch").fork(static_cast<std::uint64_t>(v))));
  const int n = static_cast<int>(std::ceil(c.ground.reach_m / c.ground.patch_m));
  for (int j = -n; j <= n; ++j) {
    for (int i = -n; i <= n; ++i) {
      const double x = i * c.ground.patch_m, y = j * c.ground.patch_m;
      if (std::hypot(x, y) > c.ground.reach_m) continue;
      Rng own = rng.fork("place").fork(static_cast<std::uint64_t>((j + n) * (2 * n + 1) + i + n));
      const int variant = static_cast<int>(uniform_index(own, kVariants));
      const double turn = uniform(own, 0, 2 * kPi);
      // Fewer patches where the strip's edge frays.
      if (uniform(own) > in_alley(c, x, y, key + 4)) continue;
      add_instance(scene, "sward", "ground", first + variant, material,
                   {Eigen::Quaterniond(Eigen::AngleAxisd(turn, Vector3d::UnitZ())),
                    Vector3d(x, y, height_at(c, x, y, key))});
    }
  }
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
  const std::uint64_t key = rng.fork("relief")();
  Material soil;
  soil.name = "bare soil";
  soil.albedo = to_rgb(color_vector(c.ground.soil));
  soil.noise = NoiseTexture{to_rgb(color_vector(c.ground.soil_other)), 0.25, 9};
  soil.ior = 1;
  soil.roughness = 1;
  soil.infrared_albedo = 0.35F;
  Material sward = soil;  // what blades that are too far away to stand leave of their colour
  sward.name = "sward";
  const Vector3d grass = color_vector(c.ground.grass), dry = color_vector(c.ground.grass_dry);
  sward.albedo = to_rgb(Vector3d(0.75 * grass + 0.06 * dry));
  sward.noise = NoiseTexture{to_rgb(Vector3d(0.45 * grass + 0.20 * dry)), 0.5, 9};
  const int material = append(scene.materials, std::move(soil));
  append(scene.materials, std::move(sward));
  const int model = append(scene.models, ground_model(c, key));
  add_instance(scene, "ground", "ground", model, material, {}).part_materials = {material,
                                                                                 material + 1};
  add_sward(scene, c, key, rng.fork("sward"));
  add_trellis(scene, c);
  for (int i = 0; i < c.ground.fallen && !leaf_models.empty(); ++i) {
    Rng own = rng.fork("fallen").fork(static_cast<std::uint64_t>(i));
    const double x = uniform(own, -1.5, 1.5), y = 1.2 * c.ground.strip_m * uniform(own, -1, 1);
    const int leaf = leaf_models[uniform_index(own, leaf_models.size())];
    const Eigen::Quaterniond flat =
        Eigen::AngleAxisd(uniform(own, 0, 2 * kPi), Vector3d::UnitZ()) *
        Eigen::AngleAxisd(uniform(own) < 0.5 ? kPi : 0.0, Vector3d::UnitX()) *
        Eigen::AngleAxisd(0.2 * normal(own), Vector3d::UnitY());
    add_instance(scene, "fallen leaf", "ground", leaf, leaf_parts.front(),
                 {flat, Vector3d(x, y, height_at(c, x, y, key) + 0.012)})
        .part_materials = leaf_parts;
  }
}

}  // namespace cousin
