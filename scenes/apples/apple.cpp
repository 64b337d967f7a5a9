#include "scenes/apples/apple.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sim/geometry/smooth_normals.h"

namespace cousin {
namespace {

void require(const char* key, double value, double low, double high) {
  if (value >= low && value <= high) return;
  throw std::invalid_argument("apple: " + std::string(key) + " is " + std::to_string(value) +
                              "; it must be in [" + std::to_string(low) + ", " +
                              std::to_string(high) + "]");
}

/// The surface's point on the axis, at the stalk (+1) or the calyx (-1).
Eigen::Vector3d pole(const AppleFlesh& flesh, double sign) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < flesh.directions.size(); ++i) {
    if (sign * flesh.directions[i].z() > sign * flesh.directions[best].z()) best = i;
  }
  return flesh.mesh.vertices_m[best];
}

FruitPart make_stalk(const AppleCultivar& c, const Eigen::Vector3d& base_m, double size, Rng rng) {
  FruitPart stalk;
  std::vector<Eigen::Vector3d> line;
  std::vector<double> radii_m;
  const double azimuth = uniform(rng, 0, 2 * std::numbers::pi);
  const double length_m = size * c.stalk_length_m * truncated_normal(rng, 1, c.stalk_spread, 2);
  const double bow = c.stalk_bow * truncated_normal(rng, 0, 1, 2);
  constexpr int kSteps = 12;
  for (int i = 0; i <= kSteps; ++i) {
    const double t = static_cast<double>(i) / kSteps;
    const double off = bow * length_m * t * t;
    line.emplace_back(
        base_m + Eigen::Vector3d(off * std::cos(azimuth), off * std::sin(azimuth), length_m * t));
    // Thick where it was tied to the spur.
    radii_m.push_back(size * c.stalk_radius_m * (1 + 0.7 * std::exp(-40 * (1 - t) * (1 - t))));
  }
  line[0].z() -= 0.002;
  stalk.model.name = "stalk";
  stalk.model.mesh = tube(line, radii_m, 10);
  stalk.model.vertex_normals = smooth_normals(stalk.model.mesh);
  stalk.material.name = "apple stalk";
  stalk.material.albedo = {0.16F, 0.10F, 0.05F};
  stalk.material.roughness = 0.7;
  stalk.material.ior = 1.4;
  return stalk;
}

/// Five dry sepals that stand in the dent, their ends turned out.
FruitPart make_calyx(const Eigen::Vector3d& base_m, double size, Rng rng) {
  FruitPart calyx;
  ObjectModel& model = calyx.model;
  model.name = "calyx";
  for (int i = 0; i < 5; ++i) {
    Rng one = rng.fork(static_cast<std::uint64_t>(i));
    const double azimuth = 2 * std::numbers::pi * i / 5 + 0.15 * normal(one);
    const Eigen::Vector3d out(std::cos(azimuth), std::sin(azimuth), 0);
    const Eigen::Vector3d side(-out.y(), out.x(), 0);
    const double length_m = size * 0.006 * truncated_normal(one, 1, 0.15, 2);
    const auto first = static_cast<std::uint32_t>(model.mesh.vertices_m.size());
    constexpr std::uint32_t kSteps = 5;
    for (std::uint32_t k = 0; k <= kSteps; ++k) {
      const double t = static_cast<double>(k) / kSteps;
      const double half_m = 0.22 * length_m * (1 - 0.9 * t);
      const Eigen::Vector3d at =
          base_m + length_m * (Eigen::Vector3d(0, 0, -0.9 * t) + (0.25 + 0.6 * t * t) * out);
      model.mesh.vertices_m.emplace_back(at - half_m * side);
      model.mesh.vertices_m.emplace_back(at + half_m * side);
      if (k == 0) continue;
      const std::uint32_t a = first + 2 * (k - 1);
      model.mesh.triangles.push_back({a, a + 1, a + 3});
      model.mesh.triangles.push_back({a, a + 3, a + 2});
    }
  }
  model.vertex_normals = smooth_normals(model.mesh);
  calyx.material.name = "apple sepal";
  calyx.material.kind = SurfaceKind::leaf;
  calyx.material.albedo = {0.14F, 0.11F, 0.05F};
  calyx.material.transmittance = {0.02F, 0.02F, 0.01F};
  calyx.material.roughness = 0.8;
  calyx.material.ior = 1.3;
  return calyx;
}

}  // namespace

void validate(const AppleConfig& config) {
  apple_cultivar(config.cultivar);
  if (config.red_share) require("red_share", *config.red_share, 0, 1);
  require("growth", config.growth, 0.1, 1);
  require("elongation", config.elongation, 0.4, 2.5);
  if (config.grid != 0) require("grid", config.grid, 4, 200);
  require("norm of to_sun", config.to_sun.norm(), 1e-6, 1e6);
}

FruitModel make_apple(const AppleConfig& config, Rng rng) {
  return make_apple(config, apple_cultivar(config.cultivar), rng);
}

FruitModel make_apple(const AppleConfig& config, const AppleCultivar& cultivar, Rng rng) {
  validate(config);
  validate(cultivar);
  AppleCultivar c = cultivar;
  if (config.grid != 0) c.grid = config.grid;
  const FruitSize drawn = draw_size(c, rng.fork("size"));
  Rng red = rng.fork("red");
  const double drawn_red = std::clamp(cut_normal(red, c.red_share, c.sigma_red_share), 0.0, 1.0);
  const double size = config.growth * std::cbrt(drawn.mass_kg / c.mass_kg);
  FruitModel fruit;
  fruit.mass_kg = drawn.mass_kg * std::pow(config.growth, 3);
  AppleFlesh flesh = make_apple_flesh(c, config.family, config.elongation * drawn.shape_index,
                                      fruit.mass_kg / drawn.density_kg_m3, rng.fork("flesh"));
  ObjectModel& model = fruit.flesh.model;
  model.name = config.cultivar;
  model.vertex_albedo =
      color_apple(c, flesh, config.red_share.value_or(drawn_red), config.to_sun, rng.fork("color"));
  fruit.traits =
      fruit_traits(flesh.mesh, red_share(flesh.mesh, model.vertex_albedo), fruit.mass_kg);
  fruit.hull = contact_hull(flesh.mesh);
  for (const Eigen::Vector3d& n : flesh.normals) model.vertex_normals.emplace_back(n.cast<float>());
  fruit.flesh.material.name = config.cultivar;
  fruit.flesh.material.albedo = {1, 1, 1};
  fruit.flesh.material.roughness = c.roughness;
  fruit.flesh.material.ior = c.ior;
  fruit.stalk_base_m = pole(flesh, 1);
  const Eigen::Vector3d calyx_m = pole(flesh, -1);
  fruit.stalk = make_stalk(c, fruit.stalk_base_m, size, rng.fork("stalk"));
  fruit.calyx = make_calyx(calyx_m, size, rng.fork("calyx"));
  // The tube's last point: the middle of its end.
  model.keypoints = {{"calyx_centre", calyx_m},
                     {"stalk_base", fruit.stalk_base_m},
                     {"cut_point", fruit.stalk.model.mesh.vertices_m.back()}};
  model.mesh = std::move(flesh.mesh);
  return fruit;
}

}  // namespace cousin
