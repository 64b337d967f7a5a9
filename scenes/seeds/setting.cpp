#include "scenes/seeds/setting.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "scenes/seeds/specimen.h"
#include "scenes/seeds/toml_text.h"
#include "sim/geometry/cube_sphere.h"
#include "sim/geometry/gradient_noise.h"
#include "sim/geometry/lattice.h"
#include "sim/geometry/smooth_normals.h"

namespace cousin {
namespace {

Rgbf to_rgb(const std::vector<double>& v) {
  return {static_cast<float>(v.at(0)), static_cast<float>(v.at(1)), static_cast<float>(v.at(2))};
}

int add_instance(Scene& scene, ObjectModel model, Material material, const char* category) {
  Instance instance;
  instance.id = static_cast<int>(scene.instances.size());
  instance.name = category;
  instance.category = category;
  instance.model = static_cast<int>(scene.models.size());
  instance.material = static_cast<int>(scene.materials.size());
  scene.models.push_back(std::move(model));
  scene.materials.push_back(std::move(material));
  scene.instances.push_back(std::move(instance));
  return scene.instances.back().id;
}

/// A face of a box: cells x cells quads from `origin` along u and v; outward is u x v.
void add_face(Mesh& mesh, const Eigen::Vector3d& origin, const Eigen::Vector3d& u,
              const Eigen::Vector3d& v, int cells_u, int cells_v) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices_m.size());
  for (int j = 0; j <= cells_v; ++j) {
    for (int i = 0; i <= cells_u; ++i) {
      mesh.vertices_m.emplace_back(origin + u * (static_cast<double>(i) / cells_u) +
                                   v * (static_cast<double>(j) / cells_v));
    }
  }
  add_lattice_triangles(mesh, first, static_cast<std::uint32_t>(cells_u),
                        static_cast<std::uint32_t>(cells_v));
}

Lamp make_lamp(const Eigen::Vector3d& centre_m, const Eigen::Vector3d& target_m,
               double half_width_m, double half_height_m, const Rgbf& radiance) {
  const Eigen::Vector3d towards = (target_m - centre_m).normalized();
  const Eigen::Vector3d u = Eigen::Vector3d::UnitZ().cross(towards).normalized();
  return {centre_m, u * half_width_m, towards.cross(u) * half_height_m, radiance};
}

}  // namespace

Fields fields(SettingConfig& c) {
  constexpr double kMetre = 10;
  return {
      {"board.thickness_m", &c.board_thickness_m, "of the plate", 1e-4, 0.1},
      {"board.cell_m", &c.board_cell_m, "edge of the plate's triangles", 1e-4, 0.1},
      {"board.paper_albedo", &c.paper_albedo, "white of the print", 0, 1},
      {"board.ink_albedo", &c.ink_albedo, "black of the print", 0, 1},
      {"board.roughness", &c.board_roughness, "of the print", 0.05, 1},
      {"board.ior", &c.board_ior, "of the print", 1, 2.5},
      {"screen.radius_m", &c.screen_radius_m, "of the green floor", 0.1, kMetre},
      {"screen.wall_m", &c.screen_wall_m, "height of the green wall around it", 0, kMetre},
      {"screen.albedo", &c.screen_albedo, "chroma-key green", 0, 1},
      {"screen.white", &c.screen_white, "a white table", 0, 1},
      {"screen.black", &c.screen_black, "a black cloth", 0, 1},
      {"screen.wood", &c.screen_wood, "a table of light wood", 0, 1},
      {"sphere.radius_m", &c.sphere_radius_m, "reference sphere", 1e-3, 0.1},
      {"sphere.grid", &c.sphere_grid, "cells along an edge of its cube", 4, 400},
      {"sphere.albedo", &c.sphere_albedo, "mean", 0, 1},
      {"sphere.speckle", &c.sphere_speckle, "relative contrast", 0, 1},
      {"sphere.speckle_scale_m", &c.sphere_speckle_scale_m, "size of a speckle", 1e-5, 0.1},
      {"specimen.density_kg_m3", &c.specimen_density_kg_m3, "of a user's mesh", 10, 20000},
      {"specimen.albedo", &c.specimen_albedo, "of a user's mesh", 0, 1},
      {"specimen.mottle", &c.specimen_mottle, "relative contrast", 0, 1},
      {"specimen.mottle_scale_m", &c.specimen_mottle_scale_m, "coarsest scale", 1e-5, 0.1},
      {"placing.spot_radius_m", &c.spot_radius_m, "disc of the release points", 1e-3, 1},
      {"placing.spot_gap_m", &c.spot_gap_m, "between bounding spheres at release", 0, 1},
      {"placing.rest_gap_m", &c.rest_gap_m, "between outlines at rest", 0, 1},
      {"placing.reach_m", &c.reach_m, "farthest part from the centre", 1e-3, 1},
      {"placing.drop_height_m", &c.drop_height_m, "lowest point above the board", 0, 1},
      {"placing.attempts", &c.attempts, "draws before giving up", 1, 1000},
      {"heap.friction", &c.heap_friction, "sliding, of seed on seed and board", 0, 10},
      {"heap.rolling_friction_m", &c.heap_rolling_friction_m,
       "torque against rolling over normal force", 0, 0.01},
      {"heap.drag_per_s", &c.heap_drag_per_s, "slows what is poured", 0, 100},
      {"heap.time_s", &c.heap_time_s, "simulated before giving up", 0.1, 60},
      {"heap.rest_energy_j", &c.heap_rest_energy_j, "of all at rest", 1e-18, 1},
      {"heap.penetration_m", &c.heap_penetration_m, "deepest allowed overlap", 0, 0.01},
  };
}

void validate(const SettingConfig& c) {
  for (const auto* albedo :
       {&c.paper_albedo, &c.ink_albedo, &c.screen_albedo, &c.screen_white, &c.screen_black,
        &c.screen_wood, &c.sphere_albedo, &c.specimen_albedo}) {
    if (albedo->size() != 3) throw std::invalid_argument("setting.toml: an albedo needs 3 numbers");
  }
  if (c.reach_m < c.spot_radius_m)
    throw std::invalid_argument("placing.reach_m is below placing.spot_radius_m");
}

const SettingConfig& seeds_setting() {
  static const SettingConfig setting = [] {
    SettingConfig config;
    read_toml_text(setting_toml(), "scenes/seeds/setting.toml", fields(config), MissingKeys::error);
    validate(config);
    return config;
  }();
  return setting;
}

const std::vector<double>& background_albedo(const SettingConfig& setting,
                                             const std::string& background) {
  if (background == "green") return setting.screen_albedo;
  if (background == "white") return setting.screen_white;
  if (background == "black") return setting.screen_black;
  if (background == "wood") return setting.screen_wood;
  throw std::invalid_argument("background \"" + background +
                              "\" is not one of green, white, black, wood");
}

void add_board(Scene& scene, const SettingConfig& setting, const SeedBoard& board,
               const SheetShape& sheet) {
  const double h = board.plate_m / 2;
  const double t = setting.board_thickness_m;
  const int cells =
      std::max(1, static_cast<int>(std::lround(board.plate_m / setting.board_cell_m)));
  const Eigen::Vector3d x(2 * h, 0, 0);
  const Eigen::Vector3d y(0, 2 * h, 0);
  const Eigen::Vector3d z(0, 0, t);
  ObjectModel model;
  model.name = "board";
  add_face(model.mesh, {-h, -h, 0}, x, y, cells, cells);
  add_face(model.mesh, {-h, -h, -t}, y, x, 1, 1);
  add_face(model.mesh, {-h, -h, -t}, x, z, cells, 1);
  add_face(model.mesh, {h, -h, -t}, y, z, cells, 1);
  add_face(model.mesh, {h, h, -t}, -x, z, cells, 1);
  add_face(model.mesh, {-h, h, -t}, -y, z, cells, 1);
  for (Eigen::Vector3d& vertex_m : model.mesh.vertices_m) {
    if (vertex_m.z() > -0.5 * t) vertex_m.z() += sheet.height_m(vertex_m.x());
  }
  Material material;
  material.name = "printed paper";
  material.albedo = to_rgb(setting.paper_albedo);
  material.ink_albedo = to_rgb(setting.ink_albedo);
  material.roughness = setting.board_roughness;
  material.ior = setting.board_ior;
  material.print = board;
  material.print_bend_m = std::abs(sheet.sag_m);
  add_instance(scene, std::move(model), std::move(material), "board");
}

void add_screen(Scene& scene, const SettingConfig& setting, const std::string& background) {
  // A dish: flat floor, a quarter-round foot, an upright wall. Rows of rings from the centre
  // outward.
  const double r = setting.screen_radius_m;
  const double foot = std::min(setting.screen_wall_m, 0.3);
  constexpr int kSides = 192;
  std::vector<Eigen::Vector2d> profile;  // radius, height
  // Light is stored at vertices: 2 mm apart where the plate's shadow falls, from inside its edges
  // to beyond its corners.
  const double plate = SeedBoard{}.plate_m;
  profile.emplace_back(0.25 * plate, 0);
  for (double radius = 0.44 * plate; radius < plate; radius += 0.002)
    profile.emplace_back(radius, 0);
  for (double radius = plate; radius < r - foot; radius *= 1.15) profile.emplace_back(radius, 0);
  profile.emplace_back(r - foot, 0);
  for (int i = 1; i <= 6; ++i) {
    const double angle = std::numbers::pi / 2 * i / 6;
    profile.emplace_back(r - foot + foot * std::sin(angle), foot * (1 - std::cos(angle)));
  }
  if (setting.screen_wall_m > foot) profile.emplace_back(r, setting.screen_wall_m);

  ObjectModel model;
  model.name = "screen";
  const double z0 = -setting.board_thickness_m;
  model.mesh.vertices_m.emplace_back(0, 0, z0);
  for (const Eigen::Vector2d& p : profile) {
    for (int k = 0; k < kSides; ++k) {
      const double angle = 2 * std::numbers::pi * k / kSides;
      model.mesh.vertices_m.emplace_back(p.x() * std::cos(angle), p.x() * std::sin(angle),
                                         z0 + p.y());
    }
  }
  const auto at = [&](std::size_t ring, int side) {
    return static_cast<std::uint32_t>(1 + ring * kSides + static_cast<std::size_t>(side % kSides));
  };
  for (int k = 0; k < kSides; ++k) model.mesh.triangles.push_back({0, at(0, k), at(0, k + 1)});
  for (std::size_t ring = 0; ring + 1 < profile.size(); ++ring) {
    for (int k = 0; k < kSides; ++k) {
      model.mesh.triangles.push_back({at(ring, k), at(ring + 1, k), at(ring + 1, k + 1)});
      model.mesh.triangles.push_back({at(ring, k), at(ring + 1, k + 1), at(ring, k + 1)});
    }
  }
  model.vertex_normals = smooth_normals(model.mesh);
  Material material;
  material.name = background == "green" ? "green fabric" : background;
  material.albedo = to_rgb(background_albedo(setting, background));
  material.ior = 1;
  material.roughness = 1;
  add_instance(scene, std::move(model), std::move(material), "screen");
}

void add_lights(Scene& scene, const std::string& light) {
  // All radiances are free: no room or sky was measured. They are chosen for plausible contrasts
  // and tints, and on a scale where the board's paper (reflectance 0.80) comes out between 0.45 and
  // 0.6 and nothing but mirrored lights above 1; the phone sets its own exposure, so that only
  // ratios matter. E is the irradiance that each puts on the board, by its solid angle and cosine.
  const Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  if (light == "window") {
    // A room: bright walls and ceiling (E = 1.1), a window of 1.0 m x 1.2 m to one side, bluish as
    // daylight is (0.6), a weak warm reflection from the other (0.13).
    scene.lights.emplace_back(
        Sky{{0.36F, 0.36F, 0.35F}, {0.30F, 0.30F, 0.30F}, {0.05F, 0.08F, 0.05F}});
    scene.lights.emplace_back(
        make_lamp({-0.95, 0.75, 1.15}, centre, 0.50, 0.60, {2.0F, 2.1F, 2.25F}));
    scene.lights.emplace_back(make_lamp({1.0, -0.6, 1.2}, centre, 0.50, 0.40, {0.7F, 0.66F, 0.6F}));
  } else if (light == "lamps") {
    // Two square lamps of half a metre on either side, warm white (E = 0.9 and 0.6), in a dim room
    // (0.3): shadows are softer than a bulb's and harder than the window's.
    scene.lights.emplace_back(
        Sky{{0.10F, 0.10F, 0.10F}, {0.08F, 0.08F, 0.08F}, {0.02F, 0.03F, 0.02F}});
    scene.lights.emplace_back(make_lamp({-0.7, -0.6, 1.0}, centre, 0.25, 0.25, {9.0F, 8.9F, 8.6F}));
    scene.lights.emplace_back(make_lamp({0.75, 0.55, 1.0}, centre, 0.25, 0.25, {6.5F, 6.4F, 6.2F}));
  } else if (light == "sun") {
    // Sun 55 degrees high (E = 1.7) and a bluish sky (0.7). Real clear skies give the sky a smaller
    // share; this one is hazy, with a bright horizon.
    Sun sun;
    sun.to_sun = Eigen::Vector3d(-0.45, 0.35, 0.82).normalized();
    sun.irradiance = {2.10F, 2.02F, 1.86F};
    scene.lights.emplace_back(sun);
    scene.lights.emplace_back(
        Sky{{0.16F, 0.20F, 0.27F}, {0.26F, 0.28F, 0.31F}, {0.05F, 0.08F, 0.05F}});
  } else {
    throw std::invalid_argument("light \"" + light + "\" is not one of window, lamps, sun");
  }
}

std::vector<Rgbf> mottle(const Mesh& mesh, const std::vector<double>& albedo, double contrast,
                         double scale_m, Rng rng) {
  const std::uint64_t key = rng();
  std::vector<Rgbf> colors;
  colors.reserve(mesh.vertices_m.size());
  for (const Eigen::Vector3d& vertex : mesh.vertices_m) {
    const double factor = 1 + 2 * contrast * fractal_noise3(vertex / scale_m, 2, key);
    const auto channel = [&](std::size_t i) {
      return static_cast<float>(std::clamp(factor * albedo[i], 0.01, 0.95));
    };
    colors.push_back({channel(0), channel(1), channel(2)});
  }
  return colors;
}

SeedModel make_sphere(const SettingConfig& setting, Rng rng) {
  Mesh mesh = cube_sphere(setting.sphere_grid);
  for (Eigen::Vector3d& vertex : mesh.vertices_m) vertex *= setting.sphere_radius_m;
  SeedModel sphere = make_specimen("sphere", mesh, setting.specimen_density_kg_m3);
  sphere.model.vertex_albedo = mottle(sphere.model.mesh, setting.sphere_albedo,
                                      setting.sphere_speckle, setting.sphere_speckle_scale_m, rng);
  return sphere;
}

}  // namespace cousin
