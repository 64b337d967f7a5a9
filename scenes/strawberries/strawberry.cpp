#include "scenes/strawberries/strawberry.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sim/geometry/cube_sphere.h"
#include "sim/geometry/smooth_normals.h"
#include "sim/plant/color.h"

namespace cousin {
namespace {

void require(const char* key, double value, double low, double high) {
  if (value >= low && value <= high) return;
  throw std::invalid_argument("strawberry: " + std::string(key) + " is " + std::to_string(value) +
                              "; it must be in [" + std::to_string(low) + ", " +
                              std::to_string(high) + "]");
}

/// Drops, pointed to the calyx, half sunk into their dimples; appended to the flesh.
void add_achenes(ObjectModel& model, const StrawberryVariety& v, const StrawberryFlesh& flesh,
                 double size, bool coarse, Rng rng) {
  // Coarse fruits are for pictures in which an achene is a few pixels.
  const Mesh ball = cube_sphere(coarse ? 2 : 3);
  const double length_m = v.achene_length_m * std::sqrt(size);
  for (std::size_t i = 0; i < flesh.achenes.size(); ++i) {
    Rng one = rng.fork(i);
    const std::uint32_t site = flesh.achenes[i];
    const Eigen::Vector3d up = flesh.normals[site];
    Eigen::Vector3d along = Eigen::Vector3d::UnitZ() - up.z() * up;
    if (along.norm() < 0.05) along = up.unitOrthogonal();
    along = Eigen::AngleAxisd(0.25 * normal(one), up) * along.normalized();
    const Eigen::Vector3d across = up.cross(along);
    const double scale = truncated_normal(one, 1, 0.08, 2) * length_m;
    const auto first = static_cast<std::uint32_t>(model.mesh.vertices_m.size());
    // The skin around an achene tells how ripe it is.
    const Rgbf& skin = model.vertex_albedo[site];
    const double ripe =
        static_cast<double>(skin.r) > kRedOverGreen * static_cast<double>(skin.g) ? 1 : 0.15;
    const Eigen::Vector3d rgb =
        truncated_normal(one, 1, 0.15, 2) *
        (color_vector(v.albedo_achene) +
         ripe * (color_vector(v.albedo_achene_ripe) - color_vector(v.albedo_achene)));
    for (const Eigen::Vector3d& p : ball.vertices_m) {
      const double narrow = 1 - 0.35 * p.x();
      model.mesh.vertices_m.emplace_back(flesh.mesh.vertices_m[site] + 0.5 * scale * p.x() * along +
                                         0.36 * scale * narrow * p.y() * across +
                                         (0.24 * scale * p.z() + 0.08 * scale) * up);
      model.vertex_albedo.push_back(to_rgb(rgb.cwiseMin(0.95)));
    }
    for (const auto& t : ball.triangles) {
      model.mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
      model.triangle_part.push_back(1);
    }
  }
}

struct Stalk {
  FruitPart part;
  Eigen::Vector3d cut_m;  ///< on its axis
};

Stalk make_stalk(const StrawberryVariety& v, const Eigen::Vector3d& base_m, double size, Rng rng) {
  Stalk result;
  FruitPart& stalk = result.part;
  std::vector<Eigen::Vector3d> line;
  std::vector<double> radii_m;
  const double azimuth = uniform(rng, 0, 2 * std::numbers::pi);
  const double bow_m = v.stalk_bow * v.stalk_length_m * truncated_normal(rng, 0, 1, 2);
  constexpr int kSteps = 12;
  const auto at = [&](double t) -> Eigen::Vector3d {
    return base_m + Eigen::Vector3d(bow_m * t * t * std::cos(azimuth),
                                    bow_m * t * t * std::sin(azimuth), v.stalk_length_m * t);
  };
  for (int i = 0; i <= kSteps; ++i) {
    const double t = static_cast<double>(i) / kSteps;
    line.push_back(at(t));
    radii_m.push_back(std::sqrt(size) * v.stalk_radius_m * (1 + 0.9 * std::exp(-14 * t)));
  }
  line[0].z() -= 0.001;  // into the flesh
  result.cut_m = at(std::min(1.0, v.cut_point_m / v.stalk_length_m));
  stalk.model.name = "stalk";
  stalk.model.mesh = tube(line, radii_m, 12);
  stalk.model.vertex_normals = smooth_normals(stalk.model.mesh);
  stalk.material.name = "strawberry stalk";
  stalk.material.albedo = {0.20F, 0.33F, 0.07F};
  stalk.material.roughness = 0.6;
  stalk.material.ior = 1.4;
  return result;
}

}  // namespace

void validate(const StrawberryConfig& config) {
  strawberry_variety(config.variety);
  if (config.numbers) validate(*config.numbers);
  require("red_share", config.red_share, 0, 1);
  require("growth", config.growth, 0.1, 1.5);
  require("elongation", config.elongation, 0.4, 2.5);
  require("norm of to_sun", config.to_sun.norm(), 1e-6, 1e6);
  if (config.grid != 0) require("grid", config.grid, 8, 200);
}

FruitModel make_strawberry(const StrawberryConfig& config, Rng rng) {
  validate(config);
  const StrawberryVariety& v = numbers_of(config.variety, config.numbers);
  const FruitSize drawn = draw_size(v, rng.fork("size"));
  const double size = config.growth * std::cbrt(drawn.mass_kg / v.mass_kg);
  FruitModel fruit;
  fruit.mass_kg = drawn.mass_kg * std::pow(config.growth, 3);
  const StrawberryFlesh flesh = make_strawberry_flesh(
      v, config.family, config.elongation * drawn.shape_index, fruit.mass_kg / drawn.density_kg_m3,
      config.grid > 0 ? config.grid : v.grid, rng.fork("flesh"));
  ObjectModel& model = fruit.flesh.model;
  model.name = config.variety;
  model.mesh = flesh.mesh;
  model.vertex_albedo =
      color_strawberry(v, flesh, config.red_share, config.to_sun, rng.fork("color"));
  fruit.traits =
      fruit_traits(flesh.mesh, red_share(flesh.mesh, model.vertex_albedo), fruit.mass_kg);
  fruit.hull = contact_hull(flesh.mesh);
  // The vertices nearest the axis at both ends.
  const auto& points = flesh.mesh.vertices_m;
  std::size_t tip = 0;
  std::size_t base = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].z() < points[tip].z()) tip = i;
    const auto off = [&](std::size_t k) {
      return flesh.along[k] < 0.7 ? 1.0 : points[k].head<2>().norm();
    };
    if (off(i) < off(base)) base = i;
  }
  fruit.stalk_base_m = points[base];
  model.part_names = {"flesh", "achene"};
  model.triangle_part.assign(flesh.mesh.triangles.size(), 0);
  add_achenes(model, v, flesh, size, config.grid > 0 && config.grid < 60, rng.fork("achene"));
  model.vertex_normals = smooth_normals(model.mesh);
  fruit.flesh.material.name = config.variety;
  fruit.flesh.material.albedo = {1, 1, 1};
  fruit.flesh.material.roughness = v.roughness;
  fruit.flesh.material.ior = v.ior;
  const Stalk stalk = make_stalk(v, fruit.stalk_base_m, size, rng.fork("stalk"));
  fruit.stalk = stalk.part;
  fruit.calyx.model = make_calyx(v, flesh, fruit.stalk_base_m, std::sqrt(size), config.red_share,
                                 rng.fork("calyx"));
  Material& sepal = fruit.calyx.material;
  sepal.name = "strawberry sepal";
  sepal.kind = SurfaceKind::leaf;
  sepal.albedo = {0.9F, 0.88F, 0.9F};
  sepal.transmittance = {0.03F, 0.10F, 0.01F};
  sepal.ior = 1.4;
  sepal.roughness = 0.6;
  model.keypoints = {
      {"tip", points[tip]}, {"calyx_centre", fruit.stalk_base_m}, {"cut_point", stalk.cut_m}};
  return fruit;
}

}  // namespace cousin
