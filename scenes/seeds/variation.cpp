#include "scenes/seeds/variation.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "scenes/seeds/cultivar.h"

namespace cousin {
namespace {

constexpr double kBrightest = 0.95;
constexpr double kLargestMottle = 0.5;  // as CultivarConfig's limit
/// Unripe husks and pericarps: chlorophyll over pale starch. Free: no reflectance was measured.
const Eigen::Vector3d kGreen(0.30, 0.42, 0.10);

std::vector<double> varied_color(const std::vector<double>& rgb, const SeedVariation& v) {
  Eigen::Vector3d color(rgb.at(0), rgb.at(1), rgb.at(2));
  if (v.green != 0) color += v.green * (kGreen - color);
  const double root = std::sqrt(v.warmth);
  color = v.brightness * color.cwiseProduct(Eigen::Vector3d(root, 1, 1 / root));
  color = color.cwiseMin(kBrightest);
  return {color.x(), color.y(), color.z()};
}

float scaled(float value, double factor) { return static_cast<float>(factor) * value; }
Rgbf scaled(const Rgbf& c, double factor) {
  return {scaled(c.r, factor), scaled(c.g, factor), scaled(c.b, factor)};
}

}  // namespace

Fields fields(SeedVariation& v) {
  return {
      {"elongation", &v.elongation, "length over width, times the cultivar's", 0.4, 2.5},
      {"thickness", &v.thickness, "height, times the cultivar's", 0.4, 2.5},
      {"detail", &v.detail, "dents, creases, nerves, bows and lumps, times", 0, 4},
      {"harmonics", &v.harmonics, "share of a family of shapes that knows nothing of seeds", 0, 1},
      {"size", &v.size, "all lengths, times", 0.4, 2.5},
      {"fill", &v.fill, "width and height, times: how far the grain is filled", 0.4, 1.5},
      {"wrinkle_m", &v.wrinkle_m, "more fine folds", 0, 0.0004},
      {"density", &v.density, "times", 0.5, 2},
      {"green", &v.green, "share of an unripe grain's colour", 0, 1},
      {"brightness", &v.brightness, "reflectance, times; 0.95 at most", 0.2, 5},
      {"warmth", &v.warmth, "red over blue, times", 0.2, 5},
      {"mottle", &v.mottle, "contrast of the mottling, times; 0.5 at most", 0, 10},
      {"mottle_scale", &v.mottle_scale, "its scale, times", 0.1, 10},
      {"roughness", &v.roughness, "of the coat, times; between 0.05 and 1", 0.1, 10},
      {"light_turn_rad", &v.light_turn_rad, "of lamps and sun about the vertical", -7, 7},
      {"light_contrast", &v.light_contrast, "lamps and sun over room or sky, times", 0.05, 20},
      {"light_size", &v.light_size, "of lamps and the sun's disk, times", 0.1, 10},
  };
}

CultivarConfig varied(const CultivarConfig& cultivar, const SeedVariation& v) {
  CultivarConfig c = cultivar;
  for (double* detail : {&c.bend_m, &c.lump_m, &c.relief_m, &c.groove_m}) *detail *= v.detail;
  c.wrinkle_m += v.wrinkle_m;
  c.density_kg_m3 *= v.density;
  if (v.green != 0 || v.brightness != 1 || v.warmth != 1) {
    for (auto* color : {&c.albedo_body, &c.albedo_pale, &c.albedo_dark, &c.albedo_tip})
      *color = varied_color(*color, v);
  }
  c.mottle = std::min(c.mottle * v.mottle, std::max(c.mottle, kLargestMottle));
  c.mottle_scale_m *= v.mottle_scale;
  c.roughness = std::clamp(c.roughness * v.roughness, 0.05, 1.0);
  return c;
}

Eigen::Vector3d varied_size_m(const Eigen::Vector3d& size_m, const SeedVariation& v) {
  const double root = std::sqrt(v.elongation);
  return v.size * size_m.cwiseProduct(Eigen::Vector3d(root, v.fill / root, v.fill * v.thickness));
}

void vary_lights(std::vector<Light>& lights, const SeedVariation& v) {
  if (v.light_turn_rad == 0 && v.light_contrast == 1 && v.light_size == 1) return;
  const Eigen::AngleAxisd turn(v.light_turn_rad, Eigen::Vector3d::UnitZ());
  for (Light& light : lights) {
    if (auto* lamp = std::get_if<Lamp>(&light)) {
      lamp->centre_in_world_m = turn * lamp->centre_in_world_m;
      lamp->axis_u_m = v.light_size * (turn * lamp->axis_u_m);
      lamp->axis_v_m = v.light_size * (turn * lamp->axis_v_m);
      lamp->radiance = scaled(lamp->radiance, v.light_contrast / (v.light_size * v.light_size));
    } else if (auto* sun = std::get_if<Sun>(&light)) {
      sun->to_sun = turn * sun->to_sun;
      sun->angular_radius_rad *= v.light_size;
      sun->irradiance = scaled(sun->irradiance, v.light_contrast);
    }
  }
}

}  // namespace cousin
