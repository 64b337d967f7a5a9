#include <stdexcept>
#include <string>

#include "scenes/maize/maize_plant.h"
#include "scenes/maize/toml_text.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

constexpr double kFar_m = 100, kAngle = 7;

Fields fields(MaizeConfig::PlantNumbers& c) {
  return {{"leaves", &c.leaves, "in all", 4, 40},
          {"spread", &c.spread, "sigma of a plant's vigour", 0, 0.3},
          {"divergence_rad", &c.divergence_rad, "from leaf to leaf", 0, kAngle},
          {"divergence_spread_rad", &c.divergence_spread_rad, "sigma of it", 0, 2},
          {"lean_rad", &c.lean_rad, "sigma of the stalk's lean", 0, 1},
          {"zigzag_rad", &c.zigzag_rad, "between internodes", 0, 0.5},
          {"righting", &c.righting, "upwards, of a heading at each node", 0, 2}};
}

Fields fields(MaizeConfig::Stalk& c) {
  return {{"internode_m", &c.internode_m, "full length below each leaf", 1e-4, 2},
          {"begin_before", &c.begin_before, "stages before its collar", 0, 20},
          {"end_after", &c.end_after, "stages after its collar", 0, 20},
          {"long_rank", &c.long_rank, "rank of the lowest long internode", 1, 40},
          {"radius_m", &c.radius_m, "of the lowest long internode", 1e-4, 0.1},
          {"radius_tip_m", &c.radius_tip_m, "of the uppermost", 1e-4, 0.1},
          {"young_share", &c.young_share, "of the radius at V3", 0.01, 1},
          {"thick_stage", &c.thick_stage, "stage from which the radius is full", 3.1, 50},
          {"foot_share", &c.foot_share, "radius in the crown over that above", 0.1, 2},
          {"swelling", &c.swelling, "of a node over the stalk", 0, 1},
          {"swelling_m", &c.swelling_m, "e times less so far from it", 1e-4, 0.1},
          {"depth_m", &c.depth_m, "crown below the soil", 1e-3, 1},
          {"diameter_at_m", &c.diameter_at_m,
           "above the soil: stalk_diameter is the diameter there", 0, 1},
          {"albedo", &c.albedo, "of the stalk", 0, 1},
          {"albedo_node", &c.albedo_node, "of its nodes", 0, 1}};
}

Fields fields(MaizeConfig::Sheath& c) {
  return {{"length_m", &c.length_m, "full, of each leaf", 1e-3, 2},
          {"begin_before", &c.begin_before, "stages before its collar", 0.1, 20},
          {"thickness_m", &c.thickness_m, "of one", 1e-5, 0.01},
          {"ligule_m", &c.ligule_m, "height of the pale band", 1e-4, 0.1},
          {"albedo", &c.albedo, "of sheaths", 0, 1},
          {"albedo_low", &c.albedo_low, "of the lowest", 0, 1},
          {"ligule_albedo", &c.ligule_albedo, "of the collar", 0, 1}};
}

Fields midrib_fields(MaizeConfig::Blade& c) {
  return {{"midrib_radius_m", &c.midrib_radius_m, "of a blade of midrib_length_m", 1e-4, 0.05},
          {"midrib_length_m", &c.midrib_length_m, "length of that blade", 0.01, 5},
          {"midrib_tip_m", &c.midrib_tip_m, "radius at the tip", 1e-5, 0.05},
          {"droop_rad", &c.droop_rad, "of a blade of droop_length_m", -kAngle, kAngle},
          {"droop_length_m", &c.droop_length_m, "in proportion below", 0.01, 5},
          {"droop_most", &c.droop_most, "times droop_rad, of longer ones", 0, 5},
          {"droop_begin", &c.droop_begin, "share of the length", 0, 0.9},
          {"droop_spread", &c.droop_spread, "sigma of one leaf's droop", 0, 0.3},
          {"dry_after", &c.dry_after, "stages after its collar", 0, 50},
          {"dry_stages", &c.dry_stages, "how fast it dries", 0.01, 50},
          {"dry_angle_rad", &c.dry_angle_rad, "farther from the stalk when dry", 0, 3},
          {"dry_droop_rad", &c.dry_droop_rad, "more droop when dry", 0, kAngle},
          {"fall_after", &c.fall_after, "stages after its collar", 0, 50},
          {"last_to_fall", &c.last_to_fall, "rank of the highest leaf that dries", 0, 40}};
}

Fields fields(MaizeConfig::Blade& c) {
  return {{"length_m", &c.length_m, "full, of each leaf", 1e-3, 5},
          {"width_m", &c.width_m, "full, of each leaf", 1e-3, 1},
          {"size_spread", &c.size_spread, "sigma of one leaf's size", 0, 0.3},
          {"young_width", &c.young_width, "share of the width when it comes", 0, 1},
          {"tips_ahead", &c.tips_ahead, "stages between tip and collar", 0.1, 20},
          {"begin_ahead", &c.begin_ahead, "stages from its beginning to its tip", 0, 20},
          {"least_share", &c.least_share, "of its length, from which a blade is there", 1e-3, 1},
          {"outline", &c.outline, "base, peak, rise, fall, tip of the envelope", 0, 10},
          {"angle_low_rad", &c.angle_low_rad, "of the lowest from the stalk", 0, 3},
          {"angle_high_rad", &c.angle_high_rad, "of the uppermost", 0, 3},
          {"angle_spread", &c.angle_spread, "sigma of one leaf's angle", 0, 0.3},
          {"off_share", &c.off_share, "foot off the stalk's axis, over the sheath's radius", 0, 2},
          {"fold_rad", &c.fold_rad, "halves up about the midrib", -1.5, 1.5},
          {"camber", &c.camber, "of the margins", -2, 2},
          {"wave_m", &c.wave_m, "of the widest leaf's margin", 0, 0.2},
          {"wave_count", &c.wave_count, "along a blade", 0, 50},
          {"young_waves", &c.young_waves, "least share of it", 0, 1},
          {"twist_rad", &c.twist_rad, "sigma of the tip's twist", 0, kAngle},
          {"midrib_share", &c.midrib_share, "of the half width", 0, 1},
          {"albedo", &c.albedo, "of the lamina", 0, 1},
          {"albedo_midrib", &c.albedo_midrib, "of the midrib", 0, 1},
          {"albedo_young", &c.albedo_young, "in the whorl", 0, 1},
          {"albedo_dry", &c.albedo_dry, "of a dead leaf", 0, 1},
          {"albedo_back", &c.albedo_back, "of the lower side's midrib", 0, 1},
          {"transmittance", &c.transmittance, "of the lamina", 0, 1},
          {"clasp_m", &c.clasp_m, "over which the base opens from the stalk", 1e-4, 1},
          {"clasp_share", &c.clasp_share, "of the length, at most", 0.01, 1},
          {"clasp_rad", &c.clasp_rad, "half turn of the base about the stalk", 0, 3.1},
          {"funnel", &c.funnel, "how much wider the whorl is at its top, over its foot", 0, 10},
          {"funnel_m", &c.funnel_m, "height over which it widens", 0.01, 2},
          {"collar_m", &c.collar_m, "height of the pale wedge at the base", 1e-4, 1}};
}

Fields fields(MaizeConfig::Whorl& c) {
  return {{"leave_before", &c.leave_before, "stages before its collar: a leaf leaves it", 0, 20},
          {"left_after", &c.left_after, "stages after its collar: it has left", 0, 20},
          {"foot_below_m", &c.foot_below_m, "below the last collar", 0, 0.5},
          {"radius_share", &c.radius_share, "above the stalk's end, over stalk.radius_m", 0.01, 5},
          {"narrows", &c.narrows, "share of its radius that it loses", 0, 0.95},
          {"narrows_m", &c.narrows_m, "height over which it does", 0.01, 2},
          {"core_share", &c.core_share, "innermost roll over the last sheath's mouth", 0.01, 1},
          {"leaves_share", &c.leaves_share, "of that radius, for all leaves inside", 0.01, 1},
          {"rolled_share", &c.rolled_share, "of a leaf's length, in the whorl", 0, 1},
          {"closed_share", &c.closed_share, "of that, fully rolled", 0, 1},
          {"steeper", &c.steeper, "height that a leaf loses when it is out", 0, 0.9},
          {"more_rad", &c.more_rad, "half turn of a roll beyond blade.clasp_rad", 0, kAngle},
          {"angle_share", &c.angle_share, "of a leaf's angle, in the whorl", 0, 1},
          {"droop_share", &c.droop_share, "of its droop", 0, 1},
          {"off_share", &c.off_share, "foot off the axis, over the sheath's radius", 0, 2}};
}

Fields fields(MaizeConfig::Root& c) {
  return {{"count", &c.count, "prop roots a whorl", 0, 100},
          {"whorls", &c.whorls, "of them", 0, 5},
          {"begin_stage", &c.begin_stage, "at which they show", 0, 50},
          {"full_stage", &c.full_stage, "at which they are full", 0, 50},
          {"radius_m", &c.radius_m, "of one", 1e-4, 0.05},
          {"angle_rad", &c.angle_rad, "from straight down", 0, 1.5},
          {"angle_spread", &c.angle_spread, "of it, over its mean, at most", 0, 0.5},
          {"bend_rad", &c.bend_rad, "downwards over its length", -kAngle, kAngle},
          {"taper", &c.taper, "tip's radius over the base's", 0.01, 2},
          {"soil_m", &c.soil_m, "of its length, in the soil", 0, 1},
          {"height_m", &c.height_m, "of the upper whorl", 1e-3, 1},
          {"albedo", &c.albedo, "of them", 0, 1}};
}

Fields ear_fields(MaizeConfig::Flower& c) {
  return {{"ear_rank", &c.ear_rank, "leaf in whose axil it stands; 0 = none", 0, 40},
          {"ear_m", &c.ear_m, "length of the ear", 1e-3, 1},
          {"ear_radius_m", &c.ear_radius_m, "of the ear", 1e-3, 0.2},
          {"ear_outline", &c.ear_outline, "least, begin, skew, power of its radius", 0.01, 5},
          {"ear_angle_rad", &c.ear_angle_rad, "from the stalk", 0, 2},
          {"ear_above_m", &c.ear_above_m, "above its node", 0, 0.1},
          {"ear_begin_before", &c.ear_begin_before, "stages before the last collar", 0, 10},
          {"ear_end_after", &c.ear_end_after, "stages after it, full", 0.1, 10},
          {"ear_albedo", &c.ear_albedo, "of the husk", 0, 1},
          {"silks", &c.silks, "of the ear", 0, 100},
          {"silk_m", &c.silk_m, "length of the shortest", 1e-3, 1},
          {"silk_more_m", &c.silk_more_m, "by which the longest is longer", 0, 1},
          {"silk_angle_rad", &c.silk_angle_rad, "least, from the ear", 0, 2},
          {"silk_spread_rad", &c.silk_spread_rad, "more than that, at most", 0, 2},
          {"silk_divergence_rad", &c.silk_divergence_rad, "from silk to silk", 0, kAngle},
          {"silk_droop_rad", &c.silk_droop_rad, "turn towards the ground", -kAngle, kAngle},
          {"silk_radius_m", &c.silk_radius_m, "at base and tip", 1e-5, 0.01},
          {"silk_albedo", &c.silk_albedo, "of the silk", 0, 1}};
}

Fields fields(MaizeConfig::Flower& c) {
  return {{"begin_before", &c.begin_before, "stages before the last collar", 0, 10},
          {"end_after", &c.end_after, "stages after it, full", 0.1, 10},
          {"peduncle_m", &c.peduncle_m, "above the last node", 1e-3, 1},
          {"peduncle_taper", &c.peduncle_taper, "tip's radius over the base's", 0.01, 2},
          {"spike_m", &c.spike_m, "central spike", 1e-3, 1},
          {"spike_droop_rad", &c.spike_droop_rad, "turn towards the ground", -kAngle, kAngle},
          {"spike_thick", &c.spike_thick, "its radius over a branch's", 0.1, 5},
          {"branches", &c.branches, "of the tassel", 0, 100},
          {"branch_m", &c.branch_m, "length of one", 1e-3, 1},
          {"branch_spread", &c.branch_spread, "of it, over the longest", 0, 0.5},
          {"branch_divergence_rad", &c.branch_divergence_rad, "from branch to branch", 0, kAngle},
          {"branched_share", &c.branched_share, "of the spike, at up = 1", 0, 1},
          {"branch_up", &c.branch_up, "up of the last branch", 0, 1},
          {"length_less", &c.length_less, "share of length lost at up = 1", 0, 1},
          {"branch_angle_rad", &c.branch_angle_rad, "from the spike", 0, 2},
          {"angle_low", &c.angle_low, "times it, of the lowest", 0, 2},
          {"angle_less", &c.angle_less, "less than that at up = 1", 0, 2},
          {"branch_droop_rad", &c.branch_droop_rad, "turn towards the ground", -kAngle, kAngle},
          {"droop_begin", &c.droop_begin, "share of branch and spike before it", 0, 0.9},
          {"spikelet_m", &c.spikelet_m, "radius with spikelets", 1e-4, 0.05},
          {"spikelet_gap", &c.spikelet_gap, "radius between them over that", 0.01, 1},
          {"spikelet_taper", &c.spikelet_taper, "share of the radius lost at the tip", 0, 1},
          {"albedo", &c.albedo, "of the tassel", 0, 1}};
}

Fields fields(MaizeConfig::Surface& c) {
  return {{"detail_m", &c.detail_m, "length of a blade's rows", 5e-4, 1},
          {"columns", &c.columns, "cells across a blade, even", 2, 200},
          {"sides", &c.sides, "of the stalk", 3, 200},
          {"ior", &c.ior, "of the wax", 1, 2},
          {"leaf_roughness", &c.leaf_roughness, "of blades", 0.05, 1},
          {"stem_roughness", &c.stem_roughness, "of stalk and sheaths", 0.05, 1},
          {"infrared_albedo", &c.infrared_albedo, "at 850 nm", 0, 1},
          {"infrared_transmittance", &c.infrared_transmittance, "of blades at 850 nm", 0, 1}};
}

Fields fields(MaizeConfig::Field& c) {
  return {{"row_m", &c.row_m, "between rows", 0.05, kFar_m},
          {"plant_m", &c.plant_m, "between plants of a row", 0.02, kFar_m},
          {"scatter_m", &c.scatter_m, "sigma of a plant's place", 0, 1},
          {"variants", &c.variants, "different plants", 1, 1000},
          {"half_m", &c.half_m, "of the square of soil", 1, kFar_m},
          {"cell_m", &c.cell_m, "of its triangles near the plants", 2e-3, 1},
          {"clod_m", &c.clod_m, "amplitude of clods", 0, 0.5},
          {"clod_scale_m", &c.clod_scale_m, "their size", 1e-3, 10},
          {"albedo", &c.albedo, "of the soil", 0, 1},
          {"other_albedo", &c.other_albedo, "of its darker parts", 0, 1},
          {"clods", &c.clods, "that lie loose within residue_reach_m", 0, 100000},
          {"clod_radius_m", &c.clod_radius_m, "their least and largest radius", 1e-3, 0.3},
          {"far_m", &c.far_m, "coarse rows go on to; 0: none", 0, 100},
          {"clear_m", &c.clear_m, "none of them is nearer to a line of sight", 0, 100},
          {"hedge_m", &c.hedge_m, "height of trees about the field; 0: none", 0, 50},
          {"hedge_albedo", &c.hedge_albedo, "of them", 0, 1},
          {"residues", &c.residues, "straws on the soil near the plants", 0, 100000},
          {"residue_reach_m", &c.residue_reach_m, "of them", 0.1, 100},
          {"residue_m", &c.residue_m, "their least and largest length", 1e-3, 2},
          {"residue_width_m", &c.residue_width_m, "and width", 1e-4, 0.2},
          {"residue_albedo", &c.residue_albedo, "of straw", 0, 1},
          {"residue_old_albedo", &c.residue_old_albedo, "weathered", 0, 1},
          {"sun_elevation_rad", &c.sun_elevation_rad, "above the horizon", 0.05, 1.57},
          {"sun_azimuth_rad", &c.sun_azimuth_rad, "about +z", -kAngle, kAngle},
          {"turbidity", &c.turbidity, "of the air", 1.7, 10},
          {"overcast", &c.overcast, "radiance at the zenith", 0, 1e6}};
}

}  // namespace

Fields fields(MaizeConfig& c) {
  return nested("plant", fields(c.plant)) + nested("stalk", fields(c.stalk)) +
         nested("sheath", fields(c.sheath)) +
         nested("blade", fields(c.blade) + midrib_fields(c.blade)) +
         nested("whorl", fields(c.whorl)) + nested("root", fields(c.root)) +
         nested("flower", fields(c.flower) + ear_fields(c.flower)) +
         nested("surface", fields(c.surface)) + nested("field", fields(c.field)) +
         nested("sway", fields(c.sway)) + nested("limbs", fields(c.limbs));
}

void validate(const MaizeConfig& config) {
  MaizeConfig copy = config;
  check_limits(fields(copy), "maize");
  const auto require = [](const char* key, const std::vector<double>& values, int count) {
    if (values.size() == static_cast<std::size_t>(count)) return;
    throw std::invalid_argument("maize: " + std::string(key) + " has " +
                                std::to_string(values.size()) + " numbers; it needs " +
                                std::to_string(count));
  };
  require("stalk.internode_m", config.stalk.internode_m, config.plant.leaves);
  require("sheath.length_m", config.sheath.length_m, config.plant.leaves);
  require("blade.length_m", config.blade.length_m, config.plant.leaves);
  require("blade.width_m", config.blade.width_m, config.plant.leaves);
  require("blade.outline", config.blade.outline, 5);
  require("flower.ear_outline", config.flower.ear_outline, 4);
  require("flower.silk_radius_m", config.flower.silk_radius_m, 2);
  const auto& s = config.stalk;
  const auto& b = config.blade;
  const auto& f = config.flower;
  for (const auto* color : {&s.albedo,
                            &s.albedo_node,
                            &config.sheath.albedo,
                            &config.sheath.albedo_low,
                            &config.sheath.ligule_albedo,
                            &b.albedo,
                            &b.albedo_midrib,
                            &b.albedo_young,
                            &b.albedo_dry,
                            &b.albedo_back,
                            &b.transmittance,
                            &config.root.albedo,
                            &f.albedo,
                            &f.ear_albedo,
                            &f.silk_albedo,
                            &config.field.albedo,
                            &config.field.other_albedo,
                            &config.field.residue_albedo,
                            &config.field.residue_old_albedo,
                            &config.field.hedge_albedo,
                            &config.field.overcast})
    require("a colour", *color, 3);
  require("field.clod_radius_m", config.field.clod_radius_m, 2);
  require("field.residue_m", config.field.residue_m, 2);
  require("field.residue_width_m", config.field.residue_width_m, 2);
  if (config.surface.columns % 2 != 0)
    throw std::invalid_argument(
        "maize: surface.columns = " + std::to_string(config.surface.columns) + " is not even");
}

const MaizeConfig& maize() {
  static const MaizeConfig kConfig = [] {
    MaizeConfig config;
    read_toml_text(maize_toml(), "scenes/maize/maize.toml", fields(config), MissingKeys::error);
    validate(config);
    return config;
  }();
  return kConfig;
}

double maize_stage(const std::string& text, int leaves) {
  if (text == "VT") return leaves + 1;
  for (int stage = 3; stage <= leaves; ++stage) {
    if (text == "V" + std::to_string(stage)) return stage;
  }
  throw std::invalid_argument("stage \"" + text + "\" is not one of V3 .. V" +
                              std::to_string(leaves) + ", VT");
}

}  // namespace cousin
