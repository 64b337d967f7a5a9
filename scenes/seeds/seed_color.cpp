#include "scenes/seeds/seed_color.h"

#include <algorithm>
#include <cmath>

#include "sim/geometry/gradient_noise.h"

namespace cousin {
namespace {

Eigen::Vector3d to_vector(const std::vector<double>& rgb) { return {rgb[0], rgb[1], rgb[2]}; }

Eigen::Vector3d blend(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double share) {
  return a + std::clamp(share, 0.0, 1.0) * (b - a);
}

struct Palette {
  Eigen::Vector3d body, pale, dark, tip;
};

// Where a region begins and how far its colour prevails is free: chosen by eye on photographs of
// kernels, as are the colours in cultivars.toml. No reflectance was measured.

Eigen::Vector3d maize_color(const Palette& c, const SeedSkinPoint& s, double noise) {
  Eigen::Vector3d rgb = c.body;
  // Floury endosperm shines through at the crown and its dent; the embryo is paler too.
  rgb = blend(rgb, c.pale, 0.75 * smoothstep(0.78, 0.98, s.along + 0.05 * noise));
  rgb = blend(rgb, c.pale, 0.55 * s.relief);
  rgb = blend(rgb, c.pale, 0.55 * s.groove);
  rgb = blend(rgb, c.tip, 1 - smoothstep(0.07, 0.15, s.along + 0.03 * noise));
  return blend(rgb, c.dark, 1 - smoothstep(0.0, 0.014, s.along));
}

Eigen::Vector3d wheat_color(const Palette& c, const SeedSkinPoint& s, double noise) {
  Eigen::Vector3d rgb = blend(c.body, c.tip, 0.7 * s.relief);
  rgb = blend(rgb, c.pale, 0.7 * smoothstep(0.94, 1.0, s.along + 0.02 * noise));
  return blend(rgb, c.dark, 0.85 * s.groove);
}

Eigen::Vector3d rice_color(const Palette& c, const SeedSkinPoint& s, double noise) {
  Eigen::Vector3d rgb = blend(c.body, c.pale, 0.6 * s.relief);
  rgb = blend(rgb, c.dark, 0.65 * s.groove);
  rgb = blend(rgb, c.tip, 0.8 * (1 - smoothstep(0.13, 0.22, s.along + 0.02 * noise)));
  return blend(rgb, c.dark, 0.6 * smoothstep(0.985, 1.0, s.along));
}

}  // namespace

std::vector<Rgbf> color_seed(const CultivarConfig& config, const SeedShape& shape, Rng rng) {
  const Palette palette{to_vector(config.albedo_body), to_vector(config.albedo_pale),
                        to_vector(config.albedo_dark), to_vector(config.albedo_tip)};
  const std::uint64_t key = rng();
  // Free, too: 5 % in tone and 3 % in hue from seed to seed, specks where noise exceeds 0.55.
  const double brightness =
      truncated_normal(rng, 1, 0.05, 2);  // seeds of a lot differ a little in tone
  const double warmth = truncated_normal(rng, 0, 0.03, 2);
  std::vector<Rgbf> colors;
  colors.reserve(shape.surface.size());
  for (std::size_t i = 0; i < shape.surface.size(); ++i) {
    const SeedSkinPoint& s = shape.surface[i];
    const Eigen::Vector3d& x_m = shape.mesh.vertices_m[i];
    // Cells and nerves run along the seed: features are longer along x.
    const Eigen::Vector3d stretched(x_m.x() / 2.2, x_m.y(), x_m.z());
    const double fine = fractal_noise3(stretched / config.mottle_scale_m, 3, key);
    const double coarse = noise3(x_m / (4 * config.mottle_scale_m), key + 17);
    Eigen::Vector3d rgb;
    switch (config.species) {
      case Species::maize:
        rgb = maize_color(palette, s, coarse);
        break;
      case Species::wheat:
        rgb = wheat_color(palette, s, coarse);
        break;
      case Species::rice:
        rgb = rice_color(palette, s, coarse);
        break;
    }
    const double specks =
        std::max(0.0, noise3(x_m / (0.6 * config.mottle_scale_m), key + 31) - 0.55);
    const double factor =
        brightness * (1 + 2 * config.mottle * fine + config.mottle * coarse - 0.8 * specks);
    const double hue = warmth + 0.25 * config.mottle * coarse;
    const Eigen::Vector3d tint(1 + 0.3 * hue, 1, 1 - hue);
    rgb = (factor * rgb.cwiseProduct(tint)).cwiseMax(0.01).cwiseMin(0.95);
    colors.push_back(
        {static_cast<float>(rgb[0]), static_cast<float>(rgb[1]), static_cast<float>(rgb[2])});
  }
  return colors;
}

}  // namespace cousin
