#pragma once

#include <string>
#include <vector>

#include "scenes/limbs/plant_limbs.h"
#include "sim/config/fields.h"
#include "sim/physics/rigid_sway.h"
#include "sim/plant/plant.h"
#include "sim/types/rng.h"

namespace cousin {

/// maize.toml, which says what each number is and where it comes from. Every value is given there.
struct MaizeConfig {
  struct PlantNumbers {
    int leaves = 0;
    double spread = 0, divergence_rad = 0, divergence_spread_rad = 0, lean_rad = 0, zigzag_rad = 0;
    double righting = 0;
  } plant;
  struct Stalk {
    std::vector<double> internode_m;
    double begin_before = 0, end_after = 0, radius_m = 0, radius_tip_m = 0, young_share = 0;
    int long_rank = 0;
    double thick_stage = 0, foot_share = 0;
    double swelling = 0, swelling_m = 0, depth_m = 0, diameter_at_m = 0;
    std::vector<double> albedo, albedo_node;
  } stalk;
  struct Sheath {
    std::vector<double> length_m;
    double begin_before = 0, thickness_m = 0, ligule_m = 0;
    std::vector<double> albedo, albedo_low, ligule_albedo;
  } sheath;
  struct Blade {
    std::vector<double> length_m, width_m, outline;
    double tips_ahead = 0, angle_low_rad = 0, angle_high_rad = 0, droop_rad = 0, droop_begin = 0;
    double fold_rad = 0, camber = 0, wave_m = 0, wave_count = 0, twist_rad = 0, midrib_share = 0;
    std::vector<double> albedo, albedo_midrib, albedo_young, albedo_dry, albedo_back, transmittance;
    double size_spread = 0, angle_spread = 0, droop_spread = 0;
    double begin_ahead = 0, least_share = 0, young_width = 0, young_waves = 0, off_share = 0;
    double midrib_radius_m = 0, midrib_length_m = 0, midrib_tip_m = 0;
    double droop_length_m = 0, droop_most = 0;
    double clasp_m = 0, clasp_share = 0, clasp_rad = 0, collar_m = 0, funnel = 0, funnel_m = 0;
    double dry_after = 0, dry_stages = 0, dry_angle_rad = 0, dry_droop_rad = 0, fall_after = 0;
    int last_to_fall = 0;
  } blade;
  struct Whorl {  ///< leaves that are rolled about each other, and come out of it
    double leave_before = 0, left_after = 0, foot_below_m = 0;
    double radius_share = 0, narrows = 0, narrows_m = 0, core_share = 0, leaves_share = 0;
    double rolled_share = 0, closed_share = 0, steeper = 0, more_rad = 0;
    double angle_share = 0, droop_share = 0, off_share = 0;
  } whorl;
  struct Root {
    int count = 0, whorls = 0;
    double begin_stage = 0, full_stage = 0, radius_m = 0, angle_rad = 0, height_m = 0;
    double angle_spread = 0, soil_m = 0, taper = 0, bend_rad = 0;
    std::vector<double> albedo;
  } root;
  struct Flower {
    double begin_before = 0, end_after = 0;
    double peduncle_m = 0, peduncle_taper = 0, spike_m = 0;
    int branches = 0;
    double branch_m = 0, branch_angle_rad = 0, spikelet_m = 0;
    double branch_divergence_rad = 0, branch_up = 0, branched_share = 0, branch_spread = 0;
    double angle_low = 0, angle_less = 0, length_less = 0;
    double spike_droop_rad = 0, branch_droop_rad = 0, droop_begin = 0;
    double spike_thick = 0, spikelet_gap = 0, spikelet_taper = 0;
    std::vector<double> albedo;
    int ear_rank = 0;
    double ear_m = 0, ear_radius_m = 0, ear_begin_before = 0, ear_end_after = 0;
    double ear_above_m = 0, ear_angle_rad = 0;
    std::vector<double> ear_outline;
    int silks = 0;
    double silk_m = 0, silk_more_m = 0, silk_angle_rad = 0, silk_spread_rad = 0;
    double silk_droop_rad = 0, silk_divergence_rad = 0;
    std::vector<double> silk_radius_m;
    std::vector<double> ear_albedo, silk_albedo;
  } flower;
  struct Surface {
    double detail_m = 0;
    int columns = 0, sides = 0;
    double ior = 0, leaf_roughness = 0, stem_roughness = 0;
    double infrared_albedo = 0, infrared_transmittance = 0;
  } surface;
  struct Field {
    double row_m = 0, plant_m = 0, scatter_m = 0;
    int variants = 0;
    double half_m = 0, cell_m = 0, clod_m = 0, clod_scale_m = 0;
    int clods = 0;
    std::vector<double> clod_radius_m;
    std::vector<double> albedo, other_albedo;
    int residues = 0;
    double residue_reach_m = 0;
    std::vector<double> residue_m, residue_width_m, residue_albedo, residue_old_albedo;
    double sun_elevation_rad = 0, sun_azimuth_rad = 0, turbidity = 0;
    std::vector<double> overcast;
    double far_m = 0, clear_m = 0, hedge_m = 0;
    std::vector<double> hedge_albedo;
  } field;
  RigidSwayConfig sway;  ///< of whole plants
  LimbConfig limbs;
};
Fields fields(MaizeConfig& config);
/// @throws std::invalid_argument naming key, value and limit.
void validate(const MaizeConfig& config);
const MaizeConfig& maize();  ///< of maize.toml

/// "V3" .. "V18" or "VT" as the number of leaves with a collar; VT is one more than `leaves`.
/// @throws std::invalid_argument naming the text and the stages that there are.
double maize_stage(const std::string& text, int leaves);

enum MaizeLook { kStalkLook, kBladeLook, kFlowerLook };
std::vector<Material> maize_materials(const MaizeConfig& config);

/// One plant at one stage, the soil's surface at z = 0; deterministic in (config, rng), whatever
/// the stage. Organs: per rank internode, sheath, ligule, blade; then prop roots, peduncle, tassel,
/// ear. Keypoints: "root" where the stalk leaves the soil, "node n" on the stalk's axis for every
/// node above the soil, "collar n", "tip n" of each blade, "tassel tip". Traits: height (m),
/// leaf_count (collars), visible_leaf_count, leaf_area (m2), stalk_diameter (m); internode_nn (m):
/// along the axis from node n - 1 to node n, where leaf n sits, both above the soil; leaf_angle_nn
/// (rad) of leaves with a collar, from the stalk.
struct MaizePlant {
  Plant plant;
  std::vector<TrueTrait> traits;
};
/// @param stage  of maize_stage(); between two whole ones the plant is between them.
MaizePlant grow_maize(const MaizeConfig& config, double stage, Rng rng);

}  // namespace cousin
