#pragma once

#include <vector>

#include "sim/config/fields.h"

namespace cousin {

/// orchard.toml, which says what each number is and where it comes from. Every value is given
/// there.
struct OrchardConfig {
  struct Tree {
    double height_m = 0, spread = 0, trunk_radius_m = 0, trunk_tip_radius_m = 0, wander_m = 0;
    double height_most_m = 0, wander_scale_m = 0, taper = 0;
    double flare = 0, flare_m = 0, graft = 0, graft_at_m = 0, graft_m = 0;
    double spacing_m = 0, row_m = 0;
    int variants = 0;
  } tree;
  struct Branch {
    int count = 0;
    double first_m = 0, last_share = 0, divergence_rad = 0, divergence_spread_rad = 0;
    double length_m = 0, length_top_m = 0, cv_length = 0, radius_share = 0, radius_tip_m = 0,
           radius_least_m = 0;
    double angle_rad = 0, angle_spread_rad = 0, droop_rad = 0, wiggle_rad = 0;
    double scatter = 0, length_power = 0, radius_most = 0, angle_less_rad = 0, droop_less = 0;
    double young_modulus_pa = 0, strength_pa = 0, density_kg_m3 = 0, damping_time_s = 0;
  } branch;
  struct Spur {
    double spacing_m = 0, first_share = 0;
    std::vector<double> length_m;
    double radius_m = 0, bourse_m = 0;
    int leaves = 0;
    double leaves_spread = 0, leafy_share = 0, leaf_divergence_spread_rad = 0;
    double first_m = 0, last_share = 0, divergence_rad = 0, divergence_spread_rad = 0;
    double lean = 0, turn_rad = 0, wiggle_rad = 0, taper = 0;
    std::vector<double> spacing_spread;
  } spur;
  struct Shoot {
    double spacing_m = 0;
    std::vector<double> length_m;
    double radius_m = 0, leaf_spacing_m = 0, leaf_divergence_spread_rad = 0;
    double leaf_rise_rad = 0, leaf_rise_spread_rad = 0;
    double rise = 0, lean = 0, aside = 0, turn_rad = 0, wiggle_rad = 0, taper = 0;
    double last_share = 0, bare_share = 0;
    std::vector<double> first_spread, spacing_spread, leaf_spacing_spread;
  } shoot;
  struct Leaf {
    int variants = 0;
    double length_m = 0, cv_length = 0, width_share = 0, petiole_m = 0, petiole_radius_m = 0;
    int teeth = 0;
    double teeth_depth = 0, fold_rad = 0, curl_rad = 0, wave_m = 0;
    double width_spread = 0, fold_spread = 0, curl_mean = 0, curl_spread = 0, twist_rad = 0;
    double sweep_base_rad = 0, sweep_tip_rad = 0, petiole_rise_rad = 0;
    std::vector<double> outline, camber, wave_spread, wave_count, petiole_spread, petiole_curl_rad;
    double divergence_rad = 0, to_light = 0, turn_spread = 0;
    double rise_rad = 0, rise_spread_rad = 0;
    std::vector<double> albedo, albedo_vein, albedo_back, transmittance, petiole_albedo;
    double roughness = 0, ior = 0, infrared_albedo = 0, infrared_transmittance = 0;
  } leaf;
  struct Fruit {
    int variants = 0, grid = 0;
    std::vector<double> cluster_share;
    double per_m2 = 0, stalk_holds_n = 0, bourse_stiffness_n_m = 0, gap_m = 0;
    double lowest_m = 0, single_off = 0, cluster_spread_rad = 0, turn_spread_rad = 0;
  } fruit;
  struct Wood {
    std::vector<double> albedo, other_albedo;
    double texture_m = 0, relief_m = 0;
    std::vector<double> shoot_albedo, stalk_albedo;
    double roughness = 0;
  } wood;
  struct Ground {
    double half_m = 0, strip_m = 0;
    std::vector<double> soil, soil_other, grass, grass_dry, clover, fallen_yellow, fallen_brown;
    double grass_m = 0, patch_m = 0;
    int blades = 0;
    double clover_share = 0, reach_m = 0;
    int fallen = 0, weeds = 0;
    std::vector<double> wires_m;
    double wire_radius_m = 0, post_m = 0, post_radius_m = 0;
  } ground;
  struct Sway {
    double leaf_drag = 0, fruit_drag = 0, lead_s = 0, step_s = 0;
  } sway;
  struct LightNumbers {
    double elevation_rad = 0, turbidity = 0, scale = 0;
  } light;
  struct ViewNumbers {
    std::vector<double> up_rad, level_rad, down_rad;
    double azimuth_rad = 0, fruit_low_m = 0, fruit_high_m = 0;
    double tree_m = 0, tree_azimuth_rad = 0, tree_height_m = 0, tree_rise_m = 0;  ///< whole trees
  } views;
};
Fields fields(OrchardConfig& config);
/// @throws std::invalid_argument naming key, value and limit.
void validate(const OrchardConfig& config);
const OrchardConfig& orchard();  ///< of orchard.toml

/// A hand that pushes a branch and lets go while a view is taken.
struct BranchPush {
  double force_n = 0;                            ///< largest; 0 = no hand
  int branch = 0;                                ///< from the lowest
  double share = 0.8;                            ///< where, of its length
  double azimuth_rad = 0, elevation_rad = -0.8;  ///< where it pushes to, from +x to +y and up
  int view = 0;                                  ///< whose time is the middle of the push
  double seconds = 0.5;
};

}  // namespace cousin
