#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/config/fields.h"
#include "sim/truth/scene.h"

namespace cousin {

struct CultivarConfig;

/// How a lot of seeds and its light differ from the cultivar and the setting as the TOML files have
/// them. As it is by default nothing differs, to the last bit.
struct SeedVariation {
  double elongation = 1;  ///< length over width, times
  double thickness = 1;   ///< height, times
  double detail = 1;      ///< dents, creases, nerves, bows and lumps, times
  /// Share of another family of shapes: random spherical harmonics, which know nothing of seeds.
  double harmonics = 0;
  double size = 1;       ///< all lengths, times
  double fill = 1;       ///< width and height, times: how far the grain is filled
  double wrinkle_m = 0;  ///< more of the fine folds that a drying grain gets
  double density = 1;    ///< times: drier grains are denser
  double green = 0;      ///< share of an unripe grain's colour
  double brightness = 1,
         warmth = 1;  ///< reflectance and its red over its blue, times; at most 0.95
  double mottle = 1, mottle_scale = 1, roughness = 1;  ///< times, within what materials allow
  double light_turn_rad = 0;                           ///< of lamps and sun about the vertical
  double light_contrast = 1;  ///< lamps and sun over the room or sky, times
  double light_size = 1;      ///< of lamps and the sun's disk, times; their irradiance stays
};
Fields fields(SeedVariation& variation);

/// The cultivar's colours, details, gloss and density as varied; sizes stay, see varied_size_m.
CultivarConfig varied(const CultivarConfig& cultivar, const SeedVariation& variation);
Eigen::Vector3d varied_size_m(const Eigen::Vector3d& size_m, const SeedVariation& variation);
void vary_lights(std::vector<Light>& lights, const SeedVariation& variation);

}  // namespace cousin
