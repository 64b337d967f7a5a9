#include <stdexcept>
#include <string>

#include "scenes/apples/apples_toml.h"
#include "scenes/apples/orchard.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

Fields fields(OrchardConfig::Tree& c) {
  return {{"height_m", &c.height_m, "of the tree", 1, 3.5},
          {"height_most_m", &c.height_most_m, "pruned at it", 1, 3.5},
          {"spread", &c.spread, "sigma of a tree's size over its mean", 0, 0.1},
          {"trunk_radius_m", &c.trunk_radius_m, "at the ground", 5e-3, 0.2},
          {"trunk_tip_radius_m", &c.trunk_tip_radius_m, "at the top", 1e-3, 0.2},
          {"taper", &c.taper, "power of the height by which it thins", 0.1, 5},
          {"flare", &c.flare, "more radius at the ground, over it", 0, 3},
          {"flare_m", &c.flare_m, "e times less so far up", 1e-3, 1},
          {"graft", &c.graft, "more radius at the graft, over it", 0, 3},
          {"graft_at_m", &c.graft_at_m, "its height", 0, 1},
          {"graft_m", &c.graft_m, "e times less so far from it", 1e-3, 1},
          {"wander_m", &c.wander_m, "of the trunk beside a straight line", 0, 0.2},
          {"wander_scale_m", &c.wander_scale_m, "height over which it turns", 0.05, 10},
          {"spacing_m", &c.spacing_m, "of trees in the row", 0.5, 10},
          {"row_m", &c.row_m, "from row to row", 1.5, 20},
          {"variants", &c.variants, "different neighbours", 1, 20}};
}

Fields fields(OrchardConfig::Branch& c) {
  return {{"count", &c.count, "laterals on the leader", 1, 80},
          {"first_m", &c.first_m, "height of the lowest", 0.1, 3},
          {"last_share", &c.last_share, "height of the highest over the tree's", 0.2, 0.99},
          {"divergence_rad", &c.divergence_rad, "from branch to branch about the trunk", -7, 7},
          {"divergence_spread_rad", &c.divergence_spread_rad, "its sigma", 0, 2},
          {"scatter", &c.scatter, "of their heights, over their distance", 0, 0.5},
          {"length_m", &c.length_m, "of the lowest", 0.05, 2.5},
          {"length_top_m", &c.length_top_m, "of the highest", 0.05, 2.5},
          {"length_power", &c.length_power, "of the way up by which lengths pass", 0.1, 5},
          {"cv_length", &c.cv_length, "standard deviation over mean", 0, 0.3},
          {"radius_share", &c.radius_share, "base radius over length", 2e-3, 0.05},
          {"radius_tip_m", &c.radius_tip_m, "at the tip", 1e-3, 0.05},
          {"radius_least_m", &c.radius_least_m, "at the base of the shortest", 1e-3, 0.05},
          {"radius_most", &c.radius_most, "over the trunk's radius", 0.05, 1},
          {"angle_rad", &c.angle_rad, "from upright at its base", 0.2, 2.5},
          {"angle_less_rad", &c.angle_less_rad, "less than that for the highest", -1, 2},
          {"angle_spread_rad", &c.angle_spread_rad, "its sigma", 0, 0.5},
          {"droop_rad", &c.droop_rad, "turn towards the ground over its length", -1.5, 2},
          {"droop_less", &c.droop_less, "share of it that the highest lose", 0, 1},
          {"wiggle_rad", &c.wiggle_rad, "sigma of the turn between pieces", 0, 0.5},
          {"young_modulus_pa", &c.young_modulus_pa, "of the wood in bending", 1e8, 1e11},
          {"strength_pa", &c.strength_pa, "stress at which it breaks", 1e5, 1e10},
          {"density_kg_m3", &c.density_kg_m3, "of the wood", 100, 2000},
          {"damping_time_s", &c.damping_time_s, "tau: the damping ratio at f is pi f tau", 0, 1}};
}

Fields fields(OrchardConfig::Spur& c) {
  return {{"spacing_m", &c.spacing_m, "along a branch", 0.02, 1},
          {"spacing_spread", &c.spacing_spread, "least and most over spacing_m"},
          {"first_share", &c.first_share, "bare share of a branch near the trunk", 0, 0.9},
          {"first_m", &c.first_m, "more of it that is bare", 0, 1},
          {"last_share", &c.last_share, "of the branch, up to which they stand", 0.1, 1},
          {"divergence_rad", &c.divergence_rad, "from spur to spur about the branch", -7, 7},
          {"divergence_spread_rad", &c.divergence_spread_rad, "its sigma", 0, 2},
          {"lean", &c.lean, "along the branch over away from it", -5, 5},
          {"turn_rad", &c.turn_rad, "upwards over its length", -3, 3},
          {"wiggle_rad", &c.wiggle_rad, "sigma of the turn between pieces", 0, 0.5},
          {"taper", &c.taper, "radius at the tip over that at the base", 0.1, 1},
          {"length_m", &c.length_m, "least and most"},
          {"radius_m", &c.radius_m, "of a spur", 1e-3, 0.02},
          {"bourse_m", &c.bourse_m, "radius of its swollen end", 1e-3, 0.02},
          {"leaves", &c.leaves, "of a spur's rosette; 0: bare", 0, 20},
          {"leaves_spread", &c.leaves_spread, "its sigma", 0, 5},
          {"leafy_share", &c.leafy_share, "of its length, that bears them", 0, 1},
          {"leaf_divergence_spread_rad", &c.leaf_divergence_spread_rad, "sigma from leaf to leaf",
           0, 2}};
}

Fields fields(OrchardConfig::Shoot& c) {
  return {{"spacing_m", &c.spacing_m, "of one-year shoots along a branch", 0.04, 5},
          {"spacing_spread", &c.spacing_spread, "least and most over spacing_m"},
          {"first_spread", &c.first_spread, "least and most, of the first's place"},
          {"last_share", &c.last_share, "of the branch, up to which they stand", 0.1, 1},
          {"rise", &c.rise, "of its first heading, upwards", -5, 5},
          {"lean", &c.lean, "along the branch", -5, 5},
          {"aside", &c.aside, "to either side, at most", 0, 5},
          {"turn_rad", &c.turn_rad, "upwards over its length", -3, 3},
          {"wiggle_rad", &c.wiggle_rad, "sigma of the turn between pieces", 0, 0.5},
          {"taper", &c.taper, "radius at the tip over that at the base", 0.1, 1},
          {"length_m", &c.length_m, "least and most"},
          {"radius_m", &c.radius_m, "of a shoot", 1e-3, 0.02},
          {"bare_share", &c.bare_share, "of a shoot, before its first leaf", 0, 0.9},
          {"leaf_spacing_m", &c.leaf_spacing_m, "from leaf to leaf", 0.005, 1},
          {"leaf_spacing_spread", &c.leaf_spacing_spread, "least and most over leaf_spacing_m"},
          {"leaf_divergence_spread_rad", &c.leaf_divergence_spread_rad, "sigma from leaf to leaf",
           0, 2},
          {"leaf_rise_rad", &c.leaf_rise_rad, "over the plane across the shoot", -1.5, 1.5},
          {"leaf_rise_spread_rad", &c.leaf_rise_spread_rad, "its sigma", 0, 1}};
}

/// A leaf's outline and how unlike each other leaves are.
Fields blade_fields(OrchardConfig::Leaf& c) {
  return {{"outline", &c.outline, "base, peak, rise, fall, tip of the envelope", 0, 10},
          {"sweep_base_rad", &c.sweep_base_rad, "of side veins at the base", 0.2, 2.5},
          {"sweep_tip_rad", &c.sweep_tip_rad, "of side veins at the tip", 0.2, 2.5},
          {"width_spread", &c.width_spread, "sigma of the width over its mean", 0, 0.3},
          {"fold_spread", &c.fold_spread, "sigma of the fold over its mean", 0, 0.52},
          {"curl_mean", &c.curl_mean, "mean over curl_rad", -2, 2},
          {"curl_spread", &c.curl_spread, "sigma over curl_rad", 0, 2},
          {"twist_rad", &c.twist_rad, "sigma of the tip's twist", 0, 3},
          {"camber", &c.camber, "of the margins: least and most"},
          {"wave_spread", &c.wave_spread, "least and most over wave_m"},
          {"wave_count", &c.wave_count, "along the blade: least and most"},
          {"petiole_spread", &c.petiole_spread, "least and most over petiole_m"},
          {"petiole_rise_rad", &c.petiole_rise_rad, "of its base, at most", 0, 1.5},
          {"petiole_curl_rad", &c.petiole_curl_rad, "down over its length: least and most"},
          {"divergence_rad", &c.divergence_rad, "from leaf to leaf about the axis", -7, 7},
          {"to_light", &c.to_light, "pull of the upper side upwards, over its own normal", 0, 10},
          {"turn_spread", &c.turn_spread, "sigma of its normal's sides", 0, 2}};
}

Fields fields(OrchardConfig::Leaf& c) {
  return {{"variants", &c.variants, "different leaves", 1, 200},
          {"length_m", &c.length_m, "of the blade", 0.01, 0.3},
          {"cv_length", &c.cv_length, "standard deviation over mean", 0, 0.3},
          {"width_share", &c.width_share, "over length", 0.1, 2},
          {"petiole_m", &c.petiole_m, "length", 2e-3, 0.2},
          {"petiole_radius_m", &c.petiole_radius_m, "radius", 1e-4, 0.01},
          {"teeth", &c.teeth, "a side", 0, 60},
          {"teeth_depth", &c.teeth_depth, "of the half width", 0, 0.5},
          {"fold_rad", &c.fold_rad, "halves up about the midrib", -1.5, 1.5},
          {"curl_rad", &c.curl_rad, "of the midrib, tip down", -3, 3},
          {"wave_m", &c.wave_m, "undulation of the margin", 0, 0.02},
          {"rise_rad", &c.rise_rad, "over the plane across the spur", -1.5, 1.5},
          {"rise_spread_rad", &c.rise_spread_rad, "its sigma", 0, 1},
          {"albedo", &c.albedo, "upper side", 0, 1},
          {"albedo_vein", &c.albedo_vein, "of veins", 0, 1},
          {"albedo_back", &c.albedo_back, "lower side", 0, 1},
          {"transmittance", &c.transmittance, "of the lamina", 0, 1},
          {"petiole_albedo", &c.petiole_albedo, "of petioles", 0, 1},
          {"roughness", &c.roughness, "of the wax", 0.05, 1},
          {"ior", &c.ior, "of the wax", 1, 2.5},
          {"infrared_albedo", &c.infrared_albedo, "at 850 nm", 0, 1},
          {"infrared_transmittance", &c.infrared_transmittance, "at 850 nm", 0, 1}};
}

Fields fields(OrchardConfig::Fruit& c) {
  return {{"variants", &c.variants, "different fruits of a tree", 1, 500},
          {"grid", &c.grid, "cells along an edge of a fruit's cube", 8, 200},
          {"cluster_share", &c.cluster_share, "of spurs that bear 1, 2, 3 fruits", 0, 1},
          {"per_m2", &c.per_m2, "fruits to a branch's section at its base", 1e3, 1e8},
          {"stalk_holds_n", &c.stalk_holds_n, "pull at which a stalk comes off", 0.01, 1e4},
          {"bourse_stiffness_n_m", &c.bourse_stiffness_n_m, "of a stalk's base", 1e-4, 10},
          {"gap_m", &c.gap_m, "between fruits and wood as they are placed", 0, 0.1},
          {"lowest_m", &c.lowest_m, "height of the lowest fruit", 0, 3},
          {"single_off", &c.single_off, "from below its spur, of one alone, over its radius", 0, 1},
          {"cluster_spread_rad", &c.cluster_spread_rad, "sigma of a fruit's place about the spur",
           0, 1},
          {"turn_spread_rad", &c.turn_spread_rad, "sigma of its sunny side from outwards", 0, 3.2}};
}

Fields fields(OrchardConfig::Wood& c) {
  return {{"albedo", &c.albedo, "of bark", 0, 1},
          {"other_albedo", &c.other_albedo, "of its cracks", 0, 1},
          {"texture_m", &c.texture_m, "size of the largest spots", 1e-3, 1},
          {"relief_m", &c.relief_m, "of the trunk's bark", 0, 0.02},
          {"shoot_albedo", &c.shoot_albedo, "of one-year wood", 0, 1},
          {"stalk_albedo", &c.stalk_albedo, "of fruit stalks' bourses", 0, 1},
          {"roughness", &c.roughness, "of bark", 0.05, 1}};
}

Fields fields(OrchardConfig::Ground& c) {
  return {{"half_m", &c.half_m, "of the square ground", 4, 200},
          {"strip_m", &c.strip_m, "half width of the bare strip below the trees", 0, 5},
          {"soil", &c.soil, "of bare soil", 0, 1},
          {"soil_other", &c.soil_other, "of its spots", 0, 1},
          {"grass", &c.grass, "of fresh blades", 0, 1},
          {"grass_dry", &c.grass_dry, "of dry ones", 0, 1},
          {"grass_m", &c.grass_m, "height of the sward", 0.01, 1},
          {"patch_m", &c.patch_m, "edge of a patch of sward", 0.05, 2},
          {"blades", &c.blades, "a patch", 1, 20000},
          {"clover", &c.clover, "leaves of clover and weeds", 0, 0.5},
          {"clover_share", &c.clover_share, "of the patches", 0, 1},
          {"reach_m", &c.reach_m,
           "blades stand so far from the tree, coarse ones to three times; 0: none", 0, 20},
          {"fallen", &c.fallen, "leaves on the bare strip", 0, 10000},
          {"fallen_yellow", &c.fallen_yellow, "colour of a quarter of them", 0, 1},
          {"fallen_brown", &c.fallen_brown, "of two thirds", 0, 1},
          {"weeds", &c.weeds, "rosettes on the bare strip within 3 m", 0, 10000},
          {"wires_m", &c.wires_m, "heights of the trellis", 0, 10},
          {"wire_radius_m", &c.wire_radius_m, "of a wire", 1e-4, 0.02},
          {"post_m", &c.post_m, "between posts", 1, 100},
          {"post_radius_m", &c.post_radius_m, "of a post", 5e-3, 0.5}};
}

Fields fields(OrchardConfig::Sway& c) {
  return {{"leaf_drag", &c.leaf_drag, "drag coefficient of a leaf's one side", 0, 2},
          {"fruit_drag", &c.fruit_drag, "of a fruit's section", 0, 2},
          {"lead_s", &c.lead_s, "of wind before each view, from rest on", 0, 20},
          {"step_s", &c.step_s, "of the engine; at most branch.damping_time_s", 1e-4, 5e-3}};
}

Fields fields(OrchardConfig::LightNumbers& c) {
  return {{"elevation_rad", &c.elevation_rad, "of the sun", 0.05, 1.57},
          {"turbidity", &c.turbidity, "of the air", 1.7, 10},
          {"scale", &c.scale, "radiance per kcd/m2", 1e-6, 1e3}};
}

Fields fields(OrchardConfig::ViewNumbers& c) {
  return {
      {"up_rad", &c.up_rad, "least and most pitch of views that look up", -1.5, 1.5},
      {"level_rad", &c.level_rad, "of level ones", -1.5, 1.5},
      {"down_rad", &c.down_rad, "of those that look down", -1.5, 1.5},
      {"azimuth_rad", &c.azimuth_rad, "within this of straight across the row", 0, 3.1416},
      {"tree_m", &c.tree_m, "look = tree: from the trunk", 0.5, 10},
      {"tree_azimuth_rad", &c.tree_azimuth_rad, "of the outer ones beside straight across", 0, 1.4},
      {"tree_height_m", &c.tree_height_m, "what is looked at", 0.2, 5},
      {"tree_rise_m", &c.tree_rise_m, "of cameras above and below it, in turns", 0, 3},
      {"fruit_low_m", &c.fruit_low_m, "targets hang above", 0, 3.5},
      {"fruit_high_m", &c.fruit_high_m, "and below", 0, 3.5}};
}

void require_count(const char* key, const std::vector<double>& list, std::size_t count) {
  if (list.size() == count) return;
  throw std::invalid_argument(std::string("apples: ") + key + " has " +
                              std::to_string(list.size()) + " numbers; it needs " +
                              std::to_string(count));
}

void require_range(const char* key, const std::vector<double>& list, double low, double high) {
  require_count(key, list, 2);
  if (list[0] >= low && list[0] <= list[1] && list[1] <= high) return;
  throw std::invalid_argument(std::string("apples: ") + key + " [" + std::to_string(list[0]) +
                              ", " + std::to_string(list[1]) + "] is not in order within [" +
                              std::to_string(low) + ", " + std::to_string(high) + "]");
}

}  // namespace

Fields fields(OrchardConfig& c) {
  return nested("tree", fields(c.tree)) + nested("branch", fields(c.branch)) +
         nested("spur", fields(c.spur)) + nested("shoot", fields(c.shoot)) +
         nested("leaf", fields(c.leaf) + blade_fields(c.leaf)) + nested("fruit", fields(c.fruit)) +
         nested("wood", fields(c.wood)) + nested("ground", fields(c.ground)) +
         nested("sway", fields(c.sway)) + nested("light", fields(c.light)) +
         nested("views", fields(c.views));
}

void validate(const OrchardConfig& config) {
  OrchardConfig copy = config;
  check_limits(fields(copy), "apples");
  require_range("spur.length_m", config.spur.length_m, 0.003, 0.3);
  require_range("shoot.length_m", config.shoot.length_m, 0.02, 2);
  require_range("views.up_rad", config.views.up_rad, -1.5, 1.5);
  require_range("views.level_rad", config.views.level_rad, -1.5, 1.5);
  require_range("views.down_rad", config.views.down_rad, -1.5, 1.5);
  require_range("spur.spacing_spread", config.spur.spacing_spread, 0.05, 5);
  require_range("shoot.first_spread", config.shoot.first_spread, 0, 5);
  require_range("shoot.spacing_spread", config.shoot.spacing_spread, 0.05, 5);
  require_range("shoot.leaf_spacing_spread", config.shoot.leaf_spacing_spread, 0.05, 5);
  require_range("leaf.camber", config.leaf.camber, -2, 2);
  require_range("leaf.wave_spread", config.leaf.wave_spread, 0, 5);
  require_range("leaf.wave_count", config.leaf.wave_count, 0, 50);
  require_range("leaf.petiole_spread", config.leaf.petiole_spread, 0.05, 5);
  require_range("leaf.petiole_curl_rad", config.leaf.petiole_curl_rad, -3, 3);
  require_count("leaf.outline", config.leaf.outline, 5);
  require_count("fruit.cluster_share", config.fruit.cluster_share, 3);
  const auto colour = [](const char* key, const std::vector<double>& c) {
    require_count(key, c, 3);
  };
  colour("leaf.albedo", config.leaf.albedo);
  colour("leaf.albedo_vein", config.leaf.albedo_vein);
  colour("leaf.albedo_back", config.leaf.albedo_back);
  colour("leaf.transmittance", config.leaf.transmittance);
  colour("leaf.petiole_albedo", config.leaf.petiole_albedo);
  colour("wood.albedo", config.wood.albedo);
  colour("wood.other_albedo", config.wood.other_albedo);
  colour("wood.shoot_albedo", config.wood.shoot_albedo);
  colour("wood.stalk_albedo", config.wood.stalk_albedo);
  colour("ground.soil", config.ground.soil);
  colour("ground.soil_other", config.ground.soil_other);
  colour("ground.grass", config.ground.grass);
  colour("ground.grass_dry", config.ground.grass_dry);
  colour("ground.clover", config.ground.clover);
  colour("ground.fallen_yellow", config.ground.fallen_yellow);
  colour("ground.fallen_brown", config.ground.fallen_brown);
}

const OrchardConfig& orchard() {
  static const OrchardConfig kConfig = [] {
    OrchardConfig config;
    read_toml_text(orchard_toml(), "scenes/apples/orchard.toml", fields(config),
                   MissingKeys::error);
    validate(config);
    return config;
  }();
  return kConfig;
}

}  // namespace cousin
