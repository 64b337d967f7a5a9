#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/apples/apple_tree.h"
#include "sim/geometry/gradient_noise.h"
#include "sim/plant/color.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

/// Share of the material's colour at each vertex: midrib and side veins at 50 degrees are paler,
/// the lamina between them is mottled.
std::vector<Rgbf> blade_colours(const OrganSurface& surface, const BladeShape& shape,
                                const OrchardConfig::Leaf& c, double length_m, double tone,
                                std::uint64_t key) {
  const Vector3d lamina = color_vector(c.albedo), vein = color_vector(c.albedo_vein);
  const Vector3d base = lamina.cwiseMax(vein);
  std::vector<Rgbf> colours;
  for (const Eigen::Vector2d& place : surface.place) {
    const double y_m = 0.5 * shape.width_m * std::abs(place.y()) * row_share(shape, place.x());
    const double x_m = place.x() * length_m;
    // A vertex stands for the millimetres to its neighbours: a vein that is narrower is fainter.
    const double mid = 0.45 * std::exp(-std::pow(y_m / (0.0011 * (1.2 - place.x())), 2));
    // Eight pairs of side veins, curved forward.
    const double phase = (x_m - 0.75 * y_m) / (length_m / 8.5);
    const double off = std::abs(phase - std::round(phase)) * length_m / 8.5;
    const double side =
        0.55 * std::exp(-std::pow(off / 0.0012, 2)) * (1 - 0.6 * std::abs(place.y()));
    const double mottle =
        tone * (1 + 0.12 * fractal_noise3({x_m / 0.02, y_m / 0.02, place.y()}, 3, key));
    const double share = std::max(mid, side);
    const Vector3d colour = mottle * ((1 - share) * lamina + share * vein);
    colours.push_back(to_rgb(colour.cwiseQuotient(base).cwiseMax(0.02).cwiseMin(1.0)));
  }
  return colours;
}

CentreLine bowed(const Vector3d& start_m, const Vector3d& heading, double length_m, double radius_m,
                 double curl_rad, int pieces) {
  AxisGrowth g;
  g.start_m = start_m;
  g.heading = heading;
  g.length_m = length_m;
  g.radius_base_m = 1.2 * radius_m;
  g.radius_tip_m = 0.7 * radius_m;
  g.segments = pieces;
  g.curls.push_back({Vector3d::UnitY(), curl_rad, 0});
  return grow_axis(g);
}

}  // namespace

std::vector<Material> orchard_materials(const OrchardConfig& config) {
  const auto& l = config.leaf;
  const auto& w = config.wood;
  Material bark;
  bark.name = "apple bark";
  bark.albedo = to_rgb(color_vector(w.albedo));
  bark.noise = NoiseTexture{to_rgb(color_vector(w.other_albedo)), w.texture_m, 6};
  bark.roughness = w.roughness;
  bark.ior = 1.3;
  Material shoot;
  shoot.name = "apple shoot";
  shoot.albedo = to_rgb(color_vector(w.shoot_albedo));
  shoot.noise = NoiseTexture{to_rgb(Vector3d(0.65 * color_vector(w.shoot_albedo))), 0.006, 4};
  shoot.roughness = 0.55;
  shoot.ior = 1.4;
  Material petiole;
  petiole.name = "apple petiole";
  petiole.albedo = to_rgb(color_vector(l.petiole_albedo));
  petiole.roughness = 0.5;
  petiole.ior = 1.4;
  Material blade;
  blade.name = "apple leaf";
  blade.kind = SurfaceKind::leaf;
  blade.albedo = to_rgb(color_vector(l.albedo).cwiseMax(color_vector(l.albedo_vein)));
  blade.back_albedo = to_rgb(color_vector(l.albedo_back).cwiseMax(color_vector(l.albedo_vein)));
  blade.transmittance = to_rgb(color_vector(l.transmittance));
  blade.roughness = l.roughness;
  blade.ior = l.ior;
  blade.infrared_albedo = static_cast<float>(l.infrared_albedo);
  blade.infrared_transmittance = static_cast<float>(l.infrared_transmittance);
  return {bark, shoot, petiole, blade};
}

PlantModel apple_leaf(const OrchardConfig& config, int detail, Rng rng) {
  const auto& c = config.leaf;
  const double size = truncated_normal(rng, 1, c.cv_length, 2);
  const double length_m = size * c.length_m;
  Plant leaf;
  leaf.name = "apple leaf";
  const double rise = uniform(rng, 0, c.petiole_rise_rad);
  const CentreLine petiole =
      bowed(Vector3d::Zero(), {std::cos(rise), 0, std::sin(rise)},
            size * c.petiole_m * uniform(rng, c.petiole_spread[0], c.petiole_spread[1]),
            c.petiole_radius_m, uniform(rng, c.petiole_curl_rad[0], c.petiole_curl_rad[1]),
            detail ? 6 : 2);
  Organ& stalk = add_organ(leaf, OrganKind::petiole, "petiole", -1, 1);
  stalk.line = petiole;
  stalk.look = kApplePetioleLook;
  stalk.surface = tube_surface(petiole, detail ? 6 : 3);
  const Vector3d end = petiole.points_m.back();
  const Vector3d heading = (end - petiole.points_m[petiole.points_m.size() - 2]).normalized();
  const CentreLine midrib =
      bowed(end, heading, length_m, c.petiole_radius_m,
            c.curl_rad * truncated_normal(rng, c.curl_mean, c.curl_spread, 2), 16);
  BladeShape shape;
  shape.width_m = c.width_share * length_m * truncated_normal(rng, 1, c.width_spread, 2);
  shape.envelope_base = c.outline[0];
  shape.envelope_peak = c.outline[1];
  shape.envelope_rise = c.outline[2];
  shape.envelope_fall = c.outline[3];
  shape.envelope_tip = c.outline[4];
  shape.sweep_base_rad = c.sweep_base_rad;
  shape.sweep_tip_rad = c.sweep_tip_rad;
  shape.teeth = detail ? c.teeth : 0;
  shape.teeth_depth = c.teeth_depth;
  shape.fold_rad = c.fold_rad * truncated_normal(rng, 1, c.fold_spread, 1.9);
  shape.camber = uniform(rng, c.camber[0], c.camber[1]);
  shape.wave_m = c.wave_m * uniform(rng, c.wave_spread[0], c.wave_spread[1]);
  shape.wave_count = uniform(rng, c.wave_count[0], c.wave_count[1]);
  shape.wave_phase_rad = uniform(rng, 0, 2 * std::numbers::pi);
  shape.twist_rad = c.twist_rad * truncated_normal(rng, 0, 1, 2);
  Organ& blade = add_organ(leaf, OrganKind::blade, "blade", 0, 1);
  blade.line = midrib;
  blade.look = kAppleBladeLook;
  const int rows = detail ? (c.teeth > 0 ? 4 * c.teeth : 32) : 9;
  blade.surface = blade_surface(LineWalk(midrib, Vector3d::UnitZ()), shape, rows, detail ? 10 : 4);
  blade.albedo =
      blade_colours(blade.surface, shape, c, length_m, truncated_normal(rng, 0.97, 0.10, 2), rng());
  return plant_model(leaf);
}

}  // namespace cousin
