#include "scenes/apples/apple_cultivar.h"

#include <stdexcept>

#include "scenes/apples/apples_toml.h"
#include "scenes/fruit/fruit_model.h"
#include "sim/config/limits.h"

namespace cousin {

Fields fields(AppleCultivar& c) {
  return {
      {"mass_kg", &c.mass_kg, "mean", 0.01, 1},
      {"cv_mass", &c.cv_mass, "standard deviation over mean", 0, 0.4},
      {"shape_index", &c.shape_index, "mean of length over diameter", 0.5, 2},
      {"sigma_shape_index", &c.sigma_shape_index, "its standard deviation", 0, 0.2},
      {"density_kg_m3", &c.density_kg_m3, "mass over volume", 100, 2000},
      {"sigma_density_kg_m3", &c.sigma_density_kg_m3, "its standard deviation", 0, 100},
      {"waves", &c.waves, "directions of deformation", 0, 32},
      {"wave_strength", &c.wave_strength, "of the slowest wave over the radius", 0, 0.2},
      {"wave_frequency", &c.wave_frequency, "of the slowest wave", 0.1, 20},
      {"wave_step", &c.wave_step, "next wave's frequency: more by this share of the slowest", 0,
       10},
      {"roughness_share", &c.roughness_share, "random radius", 0, 0.02},
      {"roughness_frequency", &c.roughness_frequency, "its bumps across the radius", 0.1, 100},
      {"conic", &c.conic, "wider to the stalk", -0.3, 0.3},
      {"lopsided", &c.lopsided, "standard deviation of one side's excess", 0, 0.2},
      {"lopsided_along", &c.lopsided_along, "of it along the axis, over that across", 0, 5},
      {"harmonics", &c.harmonics, "strength of the family harmonics", 0, 2},
      {"stalk_dent", &c.stalk_dent, "depth over the radius", 0, 0.6},
      {"stalk_dent_rad", &c.stalk_dent_rad, "where it is e times shallower", 0.05, 1},
      {"calyx_dent", &c.calyx_dent, "depth over the radius", 0, 0.6},
      {"calyx_dent_rad", &c.calyx_dent_rad, "where it is e times shallower", 0.05, 1},
      {"calyx_lobes", &c.calyx_lobes, "five knobs about the calyx", 0, 0.1},
      {"dent_spread", &c.dent_spread, "sigma of both depths over their means", 0, 0.4},
      {"lobes_spread", &c.lobes_spread, "sigma of the knobs' height over its mean", 0, 0.5},
      {"lobes_at", &c.lobes_at, "their place over calyx_dent_rad", 0, 10},
      {"lobes_rad", &c.lobes_rad, "e times lower so far from it", 0.01, 3},
      {"stalk_length_m", &c.stalk_length_m, "of the stalk", 2e-3, 0.1},
      {"stalk_radius_m", &c.stalk_radius_m, "of the stalk", 2e-4, 0.01},
      {"stalk_spread", &c.stalk_spread, "sigma of its length over its mean", 0, 0.4},
      {"stalk_bow", &c.stalk_bow, "sigma of its end beside the axis over its length", 0, 1},
      {"red_share", &c.red_share, "mean of the red share of the surface", 0, 1},
      {"sigma_red_share", &c.sigma_red_share, "its standard deviation", 0, 0.5},
      {"maturity_medium", &c.maturity_medium, "red share from which an apple is medium, not low", 0,
       1},
      {"maturity_high", &c.maturity_high, "red share above which an apple is high, not medium", 0,
       1},
      {"albedo_ground", &c.albedo_ground, "linear reflectance", 0, 1},
      {"albedo_blush", &c.albedo_blush, "linear reflectance", 0, 1},
      {"albedo_red", &c.albedo_red, "linear reflectance", 0, 1},
      {"albedo_lenticel", &c.albedo_lenticel, "linear reflectance", 0, 1},
      {"albedo_russet", &c.albedo_russet, "linear reflectance, about the stalk", 0, 1},
      {"colour_width", &c.colour_width, "of the change to red", 0.02, 5},
      {"stripe_contrast", &c.stripe_contrast, "lead of a stripe", 0, 2},
      {"stripes", &c.stripes, "broad ones about the fruit", 1, 200},
      {"lenticels", &c.lenticels, "on the fruit", 0, 5000},
      {"lenticel_radius_m", &c.lenticel_radius_m, "of a lenticel", 1e-4, 3e-3},
      {"roughness", &c.roughness, "of the skin", 0.05, 1},
      {"ior", &c.ior, "of the skin", 1, 2.5},
      {"grid", &c.grid, "cells along an edge of the mesh's cube", 4, 200},
  };
}

void validate(const AppleCultivar& c) {
  AppleCultivar copy = c;
  check_limits(fields(copy), "fuji");
  check_maturity(c.maturity_medium, c.maturity_high);
  for (const auto* albedo :
       {&c.albedo_ground, &c.albedo_blush, &c.albedo_red, &c.albedo_lenticel, &c.albedo_russet}) {
    if (albedo->size() != 3) throw std::invalid_argument("an albedo_* needs 3 numbers");
  }
}

std::vector<std::string> apple_cultivars() { return {"fuji"}; }

const AppleCultivar& apple_cultivar(const std::string& name) {
  static const AppleCultivar fuji = [] {
    AppleCultivar read;
    read_toml_text(apples_toml(), "scenes/apples/cultivars.toml", nested("fuji", fields(read)),
                   MissingKeys::error);
    validate(read);
    return read;
  }();
  if (name != "fuji")
    throw std::invalid_argument("apple cultivar \"" + name + "\" is not one of fuji");
  return fuji;
}

}  // namespace cousin
