#include "scenes/seedlings/tray.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "sim/geometry/gradient_noise.h"
#include "sim/geometry/lattice.h"
#include "sim/geometry/measure.h"
#include "sim/geometry/smooth_normals.h"
#include "sim/plant/color.h"
#include "sim/render/spectrum.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

int add_part(Scene& scene, const std::string& name, int model, int material) {
  Instance instance;
  instance.id = static_cast<int>(scene.instances.size());
  instance.name = instance.category = name;
  instance.model = model;
  instance.material = material;
  scene.instances.push_back(std::move(instance));
  return scene.instances.back().id;
}

template <class T>
int append(std::vector<T>& list, T value) {
  list.push_back(std::move(value));
  return static_cast<int>(list.size()) - 1;
}

void add_quad(Mesh& mesh, const Vector3d& a, const Vector3d& b, const Vector3d& c,
              const Vector3d& d) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices_m.size());
  mesh.vertices_m.insert(mesh.vertices_m.end(), {a, b, c, d});
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangles.push_back({first, first + 2, first + 3});
}

/// Rings of one cell's wall, from the pitch square inwards over the rim and down.
void add_cell_walls(Mesh& mesh, const TrayConfig& config, const Vector3d& middle_m) {
  constexpr int kSides = 48;  // a multiple of 8: the square's corners are among them
  const double h = 0.5 * config.tray.pitch_m, opening = h - 0.5 * config.tray.wall_m;
  const double top = config.substrate.below_rim_m, bottom = top - config.tray.depth_m;
  const double lip = 0.15 * config.tray.wall_m;
  struct Step {
    double half, corner, z;  // corner 0: the square itself
  };
  const std::array<Step, 5> steps = {Step{h, 0, top},
                                     {opening + lip, config.tray.corner, top},
                                     {opening + 0.3 * lip, config.tray.corner, top - 0.3 * lip},
                                     {opening, config.tray.corner, top - lip},
                                     {config.tray.taper * opening, config.tray.corner, bottom}};
  const auto first = static_cast<std::uint32_t>(mesh.vertices_m.size());
  for (const Step& step : steps) {
    for (int k = 0; k < kSides; ++k) {
      const double angle = 2 * kPi * k / kSides, c = std::cos(angle), s = std::sin(angle);
      const double reach =
          step.corner == 0
              ? 1 / std::max(std::abs(c), std::abs(s))
              : std::pow(std::pow(std::abs(c), step.corner) + std::pow(std::abs(s), step.corner),
                         -1 / step.corner);
      mesh.vertices_m.emplace_back(middle_m +
                                   Vector3d(step.half * reach * c, step.half * reach * s, step.z));
    }
  }
  for (std::uint32_t ring = 0; ring + 1 < steps.size(); ++ring) {
    for (std::uint32_t k = 0; k < kSides; ++k) {
      const std::uint32_t a = first + ring * kSides + k;
      const std::uint32_t b = first + ring * kSides + (k + 1) % kSides;
      mesh.triangles.push_back({a, b, b + kSides});
      mesh.triangles.push_back({a, b + kSides, a + kSides});
    }
  }
}

ObjectModel tray_model(const TrayConfig& config) {
  ObjectModel model;
  model.name = "tray";
  for (int cell = 0; cell < config.tray.columns * config.tray.rows; ++cell)
    add_cell_walls(model.mesh, config, cell_in_world_m(config, cell));
  const double x = 0.5 * config.tray.columns * config.tray.pitch_m;
  const double y = 0.5 * config.tray.rows * config.tray.pitch_m;
  const double top = config.substrate.below_rim_m, bottom = top - config.tray.depth_m;
  const std::array<Vector3d, 4> corners = {Vector3d(-x, -y, top), Vector3d(x, -y, top),
                                           Vector3d(x, y, top), Vector3d(-x, y, top)};
  const Vector3d down(0, 0, bottom - top);
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector3d &a = corners[i], &b = corners[(i + 1) % 4];
    add_quad(model.mesh, a, a + down, b + down, b);
  }
  return model;
}

/// One grain of expanded glass: the hull of points on a lumpy ball.
Mesh grain(const Vector3d& at_m, double radius_m, Rng rng) {
  std::vector<Vector3d> points;
  for (int i = 0; i < 13; ++i) {
    const Vector3d ball(uniform(rng, -1, 1), uniform(rng, -1, 1), uniform(rng, -1, 1));
    points.emplace_back(at_m + radius_m * uniform(rng, 0.75, 1.1) *
                                   (ball.norm() > 0.1 ? ball.normalized() : Vector3d::UnitZ()));
  }
  return convex_hull(points);
}

double height_at(const TrayConfig::Substrate& c, double x, double y, std::uint64_t key) {
  const Vector3d p(x, y, 0.37);
  const double clump = c.clump_m * fractal_noise3(p / c.clump_scale_m, 3, key);
  // Grains bulge: creases between them are sharp.
  const double grains = c.grain_m * (0.6 - 2 * std::abs(noise3(p / c.grain_scale_m, key + 1)));
  // Around the stem the surface is pressed even.
  return (clump + grains) * smoothstep(0.0015, 0.010, std::hypot(x, y));
}

/// The surface of a cell with its white grains, collar at the origin.
ObjectModel substrate_model(const TrayConfig& config, int variant, Rng rng) {
  const auto& c = config.substrate;
  const double half = 0.5 * (config.tray.pitch_m - config.tray.wall_m);
  const int n = std::max(4, static_cast<int>(std::ceil(2 * half / c.detail_m)));
  const std::uint64_t key = rng.fork("surface")();
  ObjectModel model;
  model.name = "substrate " + std::to_string(variant);
  const Vector3d dark = color_vector(c.albedo_dark), light = color_vector(c.albedo_light);
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      const double x = half * (2.0 * i / n - 1), y = half * (2.0 * j / n - 1);
      model.mesh.vertices_m.emplace_back(x, y, height_at(c, x, y, key));
      const Vector3d p(x, y, 0.11);
      const double dry = std::clamp(
          0.28 + 0.55 * fractal_noise3(p / 0.004, 3, key + 2) + 0.5 * noise3(p / 0.0011, key + 3),
          0.0, 1.0);
      // Fibres lie along the ridges of a stretched noise.
      const double fibre = std::pow(
          std::max(0.0, 1 - 14 * std::abs(noise3(Vector3d(x / 0.009, y / 0.0016, 0.7), key + 4))),
          2);
      const double share = std::clamp(dry * dry + 0.6 * fibre * dry, 0.0, 1.0);
      model.vertex_albedo.push_back(to_rgb(Vector3d((1 - share) * dark + share * light)));
    }
  }
  const auto cells = static_cast<std::uint32_t>(n);
  add_lattice_triangles(model.mesh, 0, cells, cells);
  for (int k = 0; k < c.perlite; ++k) {
    Rng own = rng.fork("grain").fork(static_cast<std::uint64_t>(k));
    const double x = half * uniform(own, -0.97, 0.97), y = half * uniform(own, -0.97, 0.97);
    // Small ones are many.
    const double u = uniform(own);
    const double radius_m = c.perlite_m[0] + u * u * (c.perlite_m[1] - c.perlite_m[0]);
    const double z = height_at(c, x, y, key) + radius_m * uniform(own, -0.5, 0.4);
    const Mesh mesh = grain({x, y, z}, radius_m, own);
    const auto first = static_cast<std::uint32_t>(model.mesh.vertices_m.size());
    const double shade = uniform(own, 0.6, 1);
    for (const Vector3d& vertex : mesh.vertices_m) {
      model.mesh.vertices_m.push_back(vertex);
      model.vertex_albedo.push_back(to_rgb(Vector3d(shade * color_vector(c.perlite_albedo))));
    }
    for (const auto& t : mesh.triangles)
      model.mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  model.vertex_normals = smooth_normals(model.mesh);
  return model;
}

void add_floor(Scene& scene, const TrayConfig& config) {
  const double h = config.bench.half_m;
  const double z = config.substrate.below_rim_m - config.tray.depth_m - 1e-4;
  ObjectModel model;
  model.name = "bench";
  add_quad(model.mesh, {-h, -h, z}, {h, -h, z}, {h, h, z}, {-h, h, z});
  Material material;
  material.name = "concrete";
  material.albedo = to_rgb(color_vector(config.bench.albedo));
  material.noise =
      NoiseTexture{to_rgb(color_vector(config.bench.other_albedo)), config.bench.noise_m, 8};
  material.ior = 1;
  material.roughness = 1;
  add_part(scene, "bench", append(scene.models, std::move(model)),
           append(scene.materials, std::move(material)));
}

Lamp bar(const TrayConfig::LightNumbers& c, double y_m, const Rgbf& color) {
  // It shines along axis_u x axis_v: down.
  const auto power = static_cast<float>(c.d3_radiance);
  return {{0, y_m, c.d3_height_m},
          {0, c.d3_half_width_m, 0},
          {c.d3_half_length_m, 0, 0},
          {power * color.r, power * color.g, power * color.b}};
}

}  // namespace

Vector3d cell_in_world_m(const TrayConfig& config, int cell) {
  const int i = cell % config.tray.columns, j = cell / config.tray.columns;
  return {(i - 0.5 * (config.tray.columns - 1)) * config.tray.pitch_m,
          (j - 0.5 * (config.tray.rows - 1)) * config.tray.pitch_m, 0};
}

int add_tray(Scene& scene, const TrayConfig& config, Rng rng) {
  add_floor(scene, config);
  Material plastic;
  plastic.name = "tray plastic";
  plastic.albedo = to_rgb(color_vector(config.tray.albedo));
  plastic.roughness = config.tray.roughness;
  add_part(scene, "tray", append(scene.models, tray_model(config)),
           append(scene.materials, std::move(plastic)));
  Material peat;
  peat.name = "peat and perlite";
  peat.albedo = {1, 1, 1};  // the vertices carry the colour
  peat.ior = 1;
  peat.roughness = config.substrate.roughness;
  peat.infrared_albedo = 0.35F;
  const int material = append(scene.materials, std::move(peat));
  const int first_model = static_cast<int>(scene.models.size());
  const auto variants = static_cast<std::size_t>(config.substrate.variants);
  scene.models.resize(scene.models.size() + variants);
  tbb::parallel_for(std::size_t{0}, variants, [&](std::size_t i) {
    scene.models[static_cast<std::size_t>(first_model) + i] =
        substrate_model(config, static_cast<int>(i), rng.fork("substrate").fork(i));
  });
  const int first = static_cast<int>(scene.instances.size());
  for (int cell = 0; cell < config.tray.columns * config.tray.rows; ++cell) {
    Rng own = rng.fork("cell").fork(static_cast<std::uint64_t>(cell));
    const int variant = static_cast<int>(uniform_index(own, variants));
    char name[16];
    std::snprintf(name, sizeof name, "cell %02d", cell);
    add_part(scene, name, first_model + variant, material);
    Instance& instance = scene.instances.back();
    instance.category = "cell";
    const double turn = 0.5 * kPi * static_cast<double>(uniform_index(own, 4));
    instance.world_from_object.rotation = Eigen::AngleAxisd(turn, Vector3d::UnitZ());
    instance.world_from_object.translation_m = cell_in_world_m(config, cell);
  }
  return first;
}

Vector3d to_light(const TrayConfig& config, const std::string& light) {
  if (light != "D1") return Vector3d::UnitZ();
  const double e = config.light.d1_elevation_rad, a = config.light.d1_azimuth_rad;
  return {std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)};
}

void add_seedling_light(Scene& scene, const TrayConfig& config, const std::string& light) {
  const auto& c = config.light;
  if (light == "D1") {
    ClearSky sky;
    sky.to_sun = to_light(config, light);
    sky.turbidity = c.d1_turbidity;
    sky.scale = 0.02;
    sky.ground_albedo = to_rgb(color_vector(config.bench.albedo));
    scene.lights.emplace_back(sky);
  } else if (light == "D2") {
    const Vector3d zenith = color_vector(c.d2_zenith);
    scene.lights.emplace_back(Sky{to_rgb(zenith), to_rgb(Vector3d(c.d2_horizon_share * zenith)),
                                  to_rgb(Vector3d(0.1 * zenith))});
  } else if (light == "D3") {
    const std::array<LedPeak, 2> peaks = {LedPeak{c.d3_blue_m, c.d3_width_m, c.d3_blue_share},
                                          {c.d3_red_m, c.d3_width_m, 1 - c.d3_blue_share}};
    const Rgbf color = led_color(peaks);
    const double pitch_m = config.tray.rows * config.tray.pitch_m / c.d3_lamps * 1.6;
    for (int i = 0; i < c.d3_lamps; ++i)
      scene.lights.emplace_back(bar(c, (i - 0.5 * (c.d3_lamps - 1)) * pitch_m, color));
    scene.lights.emplace_back(Sky{to_rgb(color_vector(c.d3_room)), to_rgb(color_vector(c.d3_room)),
                                  to_rgb(color_vector(c.d3_room))});
  } else {
    throw std::invalid_argument("light \"" + light + "\" is not one of D1, D2, D3");
  }
}

}  // namespace cousin
