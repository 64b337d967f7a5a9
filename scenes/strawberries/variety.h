#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/config/fields.h"

namespace cousin {

/// One variety's table in varieties.toml, which says what each number is and where it comes from.
/// Every value is given there.
struct StrawberryVariety {
  double mass_kg = 0, cv_mass = 0;                ///< of ripe fruits
  double shape_index = 0, sigma_shape_index = 0;  ///< length over diameter
  double density_kg_m3 = 0, sigma_density_kg_m3 = 0;
  // Outline: radius s^taper (1 - s^shoulder)^closing at a share s of the length from the tip.
  double taper = 0, shoulder = 0, closing = 0;
  double hollow = 0, hollow_radius = 0;             ///< depth under the calyx over the length
  double oval = 0, lobes = 0, lumps = 0, bend = 0;  ///< standard deviations over the radius
  double lump_frequency = 0, harmonics = 0;
  int achenes = 0;
  double achene_length_m = 0, dimple_depth_m = 0, dimple_radius_m = 0;
  int sepals = 0;
  double sepal_length_m = 0, sepal_width_m = 0, sepal_rise_rad = 0;
  double stalk_radius_m = 0, stalk_length_m = 0, stalk_bow = 0, cut_point_m = 0;
  std::vector<double> albedo_green, albedo_white, albedo_blush, albedo_red;
  std::vector<double> albedo_achene, albedo_achene_ripe, albedo_sepal;
  double colour_width = 0, colour_noise = 0, sun_side = 0;
  double roughness = 0, ior = 0;
  int grid = 0;
};
Fields fields(StrawberryVariety& variety);
void validate(const StrawberryVariety& variety);

/// benihoppe, akihime, sweet_charlie.
std::vector<std::string> strawberry_varieties();
/// @throws std::invalid_argument naming the varieties that exist.
const StrawberryVariety& strawberry_variety(const std::string& name);
/// All of them, in the order of strawberry_varieties().
const std::vector<StrawberryVariety>& all_varieties();
/// Those given, else the variety's own. @throws as strawberry_variety.
const StrawberryVariety& numbers_of(const std::string& name,
                                    const std::optional<StrawberryVariety>& given);

}  // namespace cousin
