#include "scenes/strawberries/variety.h"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "scenes/strawberries/strawberry_toml.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

constexpr std::array<const char*, 3> kNames = {"benihoppe", "akihime", "sweet_charlie"};

std::vector<StrawberryVariety> read_varieties() {
  std::vector<StrawberryVariety> varieties(kNames.size());
  Fields all;
  for (std::size_t i = 0; i < kNames.size(); ++i)
    all = all + nested(kNames[i], fields(varieties[i]));
  read_toml_text(varieties_toml(), "scenes/strawberries/varieties.toml", all, MissingKeys::error);
  for (const StrawberryVariety& variety : varieties) validate(variety);
  return varieties;
}

}  // namespace

Fields fields(StrawberryVariety& v) {
  return {
      {"mass_kg", &v.mass_kg, "mean of ripe fruits", 1e-3, 0.2},
      {"cv_mass", &v.cv_mass, "standard deviation over mean", 0, 0.45},
      {"shape_index", &v.shape_index, "mean of length over diameter", 0.5, 3},
      {"sigma_shape_index", &v.sigma_shape_index, "its standard deviation", 0, 0.3},
      {"density_kg_m3", &v.density_kg_m3, "mass over volume", 100, 2000},
      {"sigma_density_kg_m3", &v.sigma_density_kg_m3, "its standard deviation", 0, 100},
      {"taper", &v.taper, "exponent at the tip: 0.5 round, 1 a cone", 0.4, 1},
      {"shoulder", &v.shoulder, "exponent: higher = widest nearer the calyx", 1, 20},
      {"closing", &v.closing, "exponent at the calyx: 0.5 round", 0.2, 1},
      {"hollow", &v.hollow, "depth under the calyx over the length", 0, 0.2},
      {"hollow_radius", &v.hollow_radius, "e times shallower there, over the length", 0.01, 1},
      {"oval", &v.oval, "of the section, over the radius", 0, 0.2},
      {"lobes", &v.lobes, "of the section, over the radius", 0, 0.2},
      {"lumps", &v.lumps, "lopsidedness over the radius", 0, 0.2},
      {"lump_frequency", &v.lump_frequency, "lumps across the radius", 0.1, 20},
      {"bend", &v.bend, "bow of the axis over the radius", 0, 0.5},
      {"harmonics", &v.harmonics, "strength of the family harmonics", 0, 2},
      {"achenes", &v.achenes, "on a fruit of mean mass", 20, 500},
      {"achene_length_m", &v.achene_length_m, "of an achene", 5e-4, 4e-3},
      {"dimple_depth_m", &v.dimple_depth_m, "under an achene", 0, 2e-3},
      {"dimple_radius_m", &v.dimple_radius_m, "where it is e times shallower", 1e-4, 4e-3},
      {"sepals", &v.sepals, "and as many bracts between them", 3, 12},
      {"sepal_length_m", &v.sepal_length_m, "of a sepal", 2e-3, 0.05},
      {"sepal_width_m", &v.sepal_width_m, "where widest", 1e-3, 0.02},
      {"sepal_rise_rad", &v.sepal_rise_rad, "of its end over the level", -1.5, 1.5},
      {"stalk_radius_m", &v.stalk_radius_m, "of the pedicel", 2e-4, 5e-3},
      {"stalk_length_m", &v.stalk_length_m, "of the pedicel left on a single fruit", 2e-3, 0.2},
      {"stalk_bow", &v.stalk_bow, "sigma of its end beside the axis over its length", 0, 1},
      {"cut_point_m", &v.cut_point_m, "above the calyx, along the stalk", 1e-3, 0.2},
      {"albedo_green", &v.albedo_green, "linear reflectance", 0, 1},
      {"albedo_white", &v.albedo_white, "linear reflectance", 0, 1},
      {"albedo_blush", &v.albedo_blush, "linear reflectance", 0, 1},
      {"albedo_red", &v.albedo_red, "linear reflectance", 0, 1},
      {"albedo_achene", &v.albedo_achene, "linear reflectance, unripe", 0, 1},
      {"albedo_achene_ripe", &v.albedo_achene_ripe, "linear reflectance, ripe", 0, 1},
      {"albedo_sepal", &v.albedo_sepal, "linear reflectance", 0, 1},
      {"colour_width", &v.colour_width, "from white to red, as a share of the length", 0.02, 2},
      {"colour_noise", &v.colour_noise, "of the front's place, as a share of the length", 0, 1},
      {"sun_side", &v.sun_side, "lead of the sunny side, as a share of the length", 0, 2},
      {"roughness", &v.roughness, "of the skin", 0.05, 1},
      {"ior", &v.ior, "of the skin", 1, 2.5},
      {"grid", &v.grid, "cells along an edge of the mesh's cube", 4, 200},
  };
}

void validate(const StrawberryVariety& v) {
  StrawberryVariety copy = v;
  check_limits(fields(copy), "variety");
  for (const auto* albedo : {&v.albedo_green, &v.albedo_white, &v.albedo_blush, &v.albedo_red,
                             &v.albedo_achene, &v.albedo_achene_ripe, &v.albedo_sepal}) {
    if (albedo->size() != 3) throw std::invalid_argument("an albedo_* needs 3 numbers");
  }
}

std::vector<std::string> strawberry_varieties() { return {kNames.begin(), kNames.end()}; }

const std::vector<StrawberryVariety>& all_varieties() {
  static const std::vector<StrawberryVariety> varieties = read_varieties();
  return varieties;
}

const StrawberryVariety& strawberry_variety(const std::string& name) {
  const auto found = std::find(kNames.begin(), kNames.end(), name);
  if (found == kNames.end()) {
    std::string known;
    for (const char* n : kNames) known += std::string(known.empty() ? "" : ", ") + n;
    throw std::invalid_argument("strawberry variety \"" + name + "\" is not one of " + known);
  }
  return all_varieties()[static_cast<std::size_t>(found - kNames.begin())];
}

const StrawberryVariety& numbers_of(const std::string& name,
                                    const std::optional<StrawberryVariety>& given) {
  const StrawberryVariety& own = strawberry_variety(name);
  return given ? *given : own;
}

}  // namespace cousin
