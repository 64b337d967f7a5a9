#pragma once

#include <string>
#include <vector>

#include "sim/config/fields.h"

namespace cousin {

/// One cultivar's table in cultivars.toml, which says what each number is and where it comes from.
/// Every value is given there.
struct AppleCultivar {
  double mass_kg = 0, cv_mass = 0;
  double shape_index = 0, sigma_shape_index = 0;  ///< length along the axis over diameter
  double density_kg_m3 = 0, sigma_density_kg_m3 = 0;
  int waves = 0;
  double wave_strength = 0, wave_frequency = 0, wave_step = 0;
  double roughness_share = 0, roughness_frequency = 0;
  double conic = 0, lopsided = 0, lopsided_along = 0, harmonics = 0;
  double stalk_dent = 0, stalk_dent_rad = 0, calyx_dent = 0, calyx_dent_rad = 0, calyx_lobes = 0;
  double dent_spread = 0, lobes_spread = 0, lobes_at = 0, lobes_rad = 0;
  double stalk_length_m = 0, stalk_radius_m = 0, stalk_spread = 0, stalk_bow = 0;
  double red_share = 0, sigma_red_share = 0;
  double maturity_medium = 0, maturity_high = 0;
  std::vector<double> albedo_ground, albedo_blush, albedo_red, albedo_lenticel, albedo_russet;
  double colour_width = 0, stripe_contrast = 0;
  int stripes = 0, lenticels = 0;
  double lenticel_radius_m = 0;
  double roughness = 0, ior = 0;
  int grid = 0;
};
Fields fields(AppleCultivar& cultivar);
void validate(const AppleCultivar& cultivar);

std::vector<std::string> apple_cultivars();
/// @throws std::invalid_argument naming the cultivars that exist.
const AppleCultivar& apple_cultivar(const std::string& name);

}  // namespace cousin
