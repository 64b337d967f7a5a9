#include <initializer_list>
#include <stdexcept>
#include <string>

#include "scenes/strawberries/strawberry_plant.h"
#include "scenes/strawberries/strawberry_toml.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

constexpr double kAngle = 3.2;

Fields fields(StrawberryPlantConfig::Crown& c) {
  return {{"radius_m", &c.radius_m, "of the crown", 1e-3, 0.05},
          {"height_m", &c.height_m, "above the bed", 1e-3, 0.1},
          {"albedo", &c.albedo, "of the crown", 0, 1}};
}

/// How leaves open, hang and differ.
Fields habit_fields(StrawberryPlantConfig::Leaf& c) {
  return {{"foot_share", &c.foot_share, "of the crown's height, where petioles begin", 0, 1},
          {"grown_age", &c.grown_age, "of the oldest's age: grown", 0.01, 1},
          {"open_age", &c.open_age, "of the oldest's age: open", 0.01, 1},
          {"vigour_spread", &c.vigour_spread, "sigma of what a plant's sizes share", 0, 0.3},
          {"size_spread", &c.size_spread, "sigma of one leaf's size", 0, 0.3},
          {"angle_spread_rad", &c.angle_spread_rad, "sigma of one petiole's angle", 0, 1},
          {"droop_spread_rad", &c.droop_spread_rad, "sigma of one blade's droop", 0, 1},
          {"angle_power", &c.angle_power, "of the age, of the petiole's angle", 0.1, 5},
          {"droop_power", &c.droop_power, "of the age, of the blade's droop", 0.1, 5},
          {"young_petiole", &c.young_petiole, "share of petiole_m when it comes", 0, 1},
          {"petiole_thick", &c.petiole_thick, "base and tip over petiole_radius_m", 0.1, 5},
          {"opening_width", &c.opening_width, "share of the width that opening adds", 0, 1},
          {"folded_side", &c.folded_side, "share of side_rad before it opens", 0, 1},
          {"side_roll", &c.side_roll, "outer leaflets' roll outwards over side_rad", -1, 1},
          {"hang_least", &c.hang_least, "share of hang_rad; the most is 1", 0, 1},
          {"hang_blade", &c.hang_blade, "of that turn, of the blade too", 0, 2},
          {"sag_begin", &c.sag_begin, "share of the petiole before it", 0, 0.9},
          {"curl_begin", &c.curl_begin, "share of the blade before it", 0, 0.9},
          {"wave_count", &c.wave_count, "along a leaflet", 0, 50}};
}

Fields fields(StrawberryPlantConfig::Leaf& c) {
  return {
      {"count_min", &c.count_min, "fewest leaves a plant", 0, 40},
      {"count_max", &c.count_max, "most leaves a plant", 1, 40},
      {"divergence_rad", &c.divergence_rad, "from leaf to leaf", 0, kAngle},
      {"spread_rad", &c.spread_rad, "sigma of it", 0, 2},
      {"petiole_m", &c.petiole_m, "of grown leaves", 0.01, 0.5},
      {"cv_length", &c.cv_length, "of it: standard deviation over mean", 0, 0.3},
      {"petiole_radius_m", &c.petiole_radius_m, "of grown leaves", 3e-4, 0.01},
      {"young_rad", &c.young_rad, "of the youngest petiole from the vertical", 0, 1.5},
      {"old_rad", &c.old_rad, "of the oldest", 0, 1.5},
      {"sag_rad", &c.sag_rad, "turn of the oldest petiole to the ground", 0, 3},
      {"lean_rad", &c.lean_rad, "out over the edge, on the path's side", 0, 1},
      {"hang_rad", &c.hang_rad, "turn of old petioles to the ground there, beyond the edge", 0, 3},
      {"reach", &c.reach, "of petioles there over the others' length", 0.5, 2},
      {"size_youngest", &c.size_youngest, "over a grown leaf's", 0.05, 1},
      {"leaflet_m", &c.leaflet_m, "length of the middle leaflet", 5e-3, 0.2},
      {"width_share", &c.width_share, "over the length", 0.1, 2},
      {"side_share", &c.side_share, "outer leaflets over the middle one", 0.1, 2},
      {"side_rad", &c.side_rad, "between outer and middle leaflet", 0.3, 2},
      {"petiolule_m", &c.petiolule_m, "stalk of the middle leaflet", 1e-3, 0.05},
      {"droop_young_rad", &c.droop_young_rad, "of the youngest blade below the level", -1.5, 1.5},
      {"droop_old_rad", &c.droop_old_rad, "of the oldest", -1.5, 1.5},
      {"curl_rad", &c.curl_rad, "of an old blade from base to tip", -kAngle, kAngle},
      {"fold_young_rad", &c.fold_young_rad, "halves of the youngest about the midrib", 0, 1.5},
      {"fold_rad", &c.fold_rad, "halves of grown ones", 0, 1.5},
      {"roll_rad", &c.roll_rad, "sigma of a blade's roll", 0, 1},
      {"camber", &c.camber, "of the margins", -2, 2},
      {"wave_m", &c.wave_m, "of the margins", 0, 0.02},
      {"quilt_m", &c.quilt_m, "bulge between side veins", 0, 0.02},
      {"veins", &c.veins, "side veins", 1, 30},
      {"teeth", &c.teeth, "a side", 0, 40},
      {"teeth_depth", &c.teeth_depth, "over the half width", 0, 0.9},
      {"outline", &c.outline, "base, peak, rise, fall, tip of the envelope", 0, 10},
      {"sweep_base_rad", &c.sweep_base_rad, "of side veins at the base", 0.2, 2.5},
      {"sweep_tip_rad", &c.sweep_tip_rad, "of side veins at the tip", 0.2, 2.5},
      {"vein_width_m", &c.vein_width_m, "of the midrib", 1e-4, 0.01},
      {"albedo", &c.albedo, "of the upper side", 0, 1},
      {"albedo_young", &c.albedo_young, "of the youngest", 0, 1},
      {"albedo_old", &c.albedo_old, "of the oldest", 0, 1},
      {"albedo_vein", &c.albedo_vein, "of veins", 0, 1},
      {"albedo_back", &c.albedo_back, "of the under side", 0, 1},
      {"transmittance", &c.transmittance, "let through", 0, 1},
      {"petiole_albedo", &c.petiole_albedo, "of petioles", 0, 1}};
}

Fields fields(StrawberryPlantConfig::Flower& c) {
  return {{"mean", &c.mean, "open flowers a plant; at most 3 come", 0, 10},
          {"stalk_m", &c.stalk_m, "length of a stalk", 0.01, 0.5},
          {"stalk_radius_m", &c.stalk_radius_m, "of a stalk", 2e-4, 0.01},
          {"stalk_rad", &c.stalk_rad, "from the vertical", 0, 1.5},
          {"length_spread", &c.length_spread, "sigma of a stalk's length", 0, 0.4},
          {"stalk_thick", &c.stalk_thick, "base and tip over stalk_radius_m", 0.1, 5},
          {"angle_spread", &c.angle_spread, "sigma of stalk_rad over its mean", 0, 0.4},
          {"stalk_sag_rad", &c.stalk_sag_rad, "turn towards the ground", -kAngle, kAngle},
          {"sag_begin", &c.sag_begin, "share of the stalk before it", 0, 0.9},
          {"facing_up", &c.facing_up, "pull of an open flower upwards", 0, 10},
          {"facing_out", &c.facing_out, "and out over the edge", 0, 10},
          {"petal_m", &c.petal_m, "length of a petal", 1e-3, 0.05},
          {"sepal_m", &c.sepal_m, "length of a sepal", 1e-3, 0.05},
          {"receptacle_m", &c.receptacle_m, "radius of the yellow middle", 5e-4, 0.02},
          {"anthers", &c.anthers, "about it", 0, 100},
          {"albedo_petal", &c.albedo_petal, "of petals", 0, 1},
          {"transmittance_petal", &c.transmittance_petal, "of petals", 0, 1},
          {"albedo_receptacle", &c.albedo_receptacle, "of the middle", 0, 1},
          {"albedo_anther", &c.albedo_anther, "of anthers", 0, 1}};
}

Fields fields(StrawberryPlantConfig::Runner& c) {
  return {{"share", &c.share, "of the plants that have one", 0, 1},
          {"length_m", &c.length_m, "of a runner", 0.05, 2},
          {"radius_m", &c.radius_m, "of a runner", 3e-4, 0.01},
          {"length_spread", &c.length_spread, "sigma of it", 0, 0.4},
          {"azimuth_rad", &c.azimuth_rad, "sigma from straight over the edge", 0, 2},
          {"rise", &c.rise, "of its first heading: least and most", 0, 5},
          {"sag_rad", &c.sag_rad, "turn towards the ground: least and most", 0, 6},
          {"leaf_share", &c.leaf_share, "size of the daughter's leaves", 0.05, 1},
          {"divergence_rad", &c.divergence_rad, "from leaf to leaf of the daughter", 0, kAngle},
          {"albedo", &c.albedo, "of runners", 0, 1}};
}

Fields fields(StrawberryPlantConfig::Surface& c) {
  return {{"rows", &c.rows, "cells along a leaflet", 4, 400},
          {"columns", &c.columns, "cells across a leaflet, even", 2, 100},
          {"sides", &c.sides, "corners of stalks", 3, 64},
          {"ior", &c.ior, "of the wax", 1, 3},
          {"leaf_roughness", &c.leaf_roughness, "of leaves", 0.05, 1},
          {"stem_roughness", &c.stem_roughness, "of stalks", 0.05, 1},
          {"infrared_albedo", &c.infrared_albedo, "at 850 nm", 0, 0.5},
          {"infrared_transmittance", &c.infrared_transmittance, "of leaves at 850 nm", 0, 0.5},
          {"clear_m", &c.clear_m, "that leaves keep off fruits and bed", 0, 0.05},
          {"tries", &c.tries, "poses of a leaf that touches something", 1, 200}};
}

}  // namespace

Fields fields(StrawberryPlantConfig& c) {
  return nested("crown", fields(c.crown)) + nested("leaf", fields(c.leaf) + habit_fields(c.leaf)) +
         nested("flower", fields(c.flower)) + nested("runner", fields(c.runner)) +
         nested("surface", fields(c.surface)) + nested("sway", fields(c.sway));
}

void validate(const StrawberryPlantConfig& config) {
  StrawberryPlantConfig copy = config;
  check_limits(fields(copy), "strawberry");
  const auto numbers = [](const char* key, const std::vector<double>& list, std::size_t count) {
    if (list.size() == count) return;
    throw std::invalid_argument("strawberry." + std::string(key) + " has " +
                                std::to_string(list.size()) + " numbers; it needs " +
                                std::to_string(count));
  };
  numbers("leaf.outline", config.leaf.outline, 5);
  numbers("leaf.petiole_thick", config.leaf.petiole_thick, 2);
  numbers("flower.stalk_thick", config.flower.stalk_thick, 2);
  numbers("runner.rise", config.runner.rise, 2);
  numbers("runner.sag_rad", config.runner.sag_rad, 2);
  const auto& l = config.leaf;
  const auto& f = config.flower;
  for (const auto* color :
       {&config.crown.albedo, &l.albedo, &l.albedo_young, &l.albedo_old, &l.albedo_vein,
        &l.albedo_back, &l.transmittance, &l.petiole_albedo, &f.albedo_petal,
        &f.transmittance_petal, &f.albedo_receptacle, &f.albedo_anther, &config.runner.albedo})
    numbers("a colour", *color, 3);
  if (l.count_min > l.count_max)
    throw std::invalid_argument("strawberry.leaf.count_min " + std::to_string(l.count_min) +
                                " is above leaf.count_max " + std::to_string(l.count_max));
  if (config.surface.columns % 2 != 0)
    throw std::invalid_argument("strawberry.surface.columns " +
                                std::to_string(config.surface.columns) + " is not even");
}

const StrawberryPlantConfig& strawberry_plant() {
  static const StrawberryPlantConfig config = [] {
    StrawberryPlantConfig read;
    read_toml_text(strawberry_plant_toml(), "scenes/strawberries/plant.toml", fields(read),
                   MissingKeys::error);
    validate(read);
    return read;
  }();
  return config;
}

}  // namespace cousin
