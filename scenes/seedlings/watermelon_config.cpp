#include <stdexcept>
#include <string>

#include "scenes/seedlings/toml_text.h"
#include "scenes/seedlings/watermelon.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

constexpr double kMetre = 1, kDays = 100, kAngle = 3.2;

Fields fields(WatermelonConfig::Emergence& c) {
  return {{"day", &c.day, "mean day after sowing at which the hook shows", 0, kDays},
          {"spread_days", &c.spread_days, "sigma", 0, kDays},
          {"failed_share", &c.failed_share, "of the seeds that never come", 0, 1},
          {"spread", &c.spread, "sigma of a plant's vigour, which its sizes share", 0, 0.4}};
}

Fields fields(WatermelonConfig::Hypocotyl& c) {
  return {{"length_m", &c.length_m, "above the substrate, full", 1e-3, kMetre},
          {"start_m", &c.start_m, "of it, on the day of emergence", 1e-4, kMetre},
          {"radius_base_m", &c.radius_base_m, "at the base", 1e-5, 0.1},
          {"radius_tip_m", &c.radius_tip_m, "at the tip", 1e-5, 0.1},
          {"days", &c.days, "from emergence to full length", 0.1, kDays},
          {"fastest_days", &c.fastest_days, "age of the fastest growth", 0, kDays},
          {"section_gain", &c.section_gain, "of the section, after emergence", 0, 1},
          {"hook_rad", &c.hook_rad, "of the hook at emergence", 0, kAngle},
          {"hook_day", &c.hook_day, "age at which it is half open", 0, kDays},
          {"hook_scale_days", &c.hook_scale_days, "how fast it opens", 0.01, kDays},
          {"hook_begin", &c.hook_begin, "share of the length below the hook", 0, 0.95},
          {"light_rad", &c.light_rad, "bending towards the light", -kAngle, kAngle},
          {"light_days", &c.light_days, "age from which it bends so far", 0.1, kDays},
          {"light_begin", &c.light_begin, "share of the length below the bend", 0, 0.95},
          {"lean_rad", &c.lean_rad, "sigma of its own lean", 0, 1},
          {"depth_m", &c.depth_m, "collar below the substrate's surface", 1e-4, kMetre},
          {"albedo", &c.albedo, "of the upper part", 0, 1},
          {"albedo_base", &c.albedo_base, "of the lower part", 0, 1}};
}

Fields fields(WatermelonConfig::Cotyledon& c) {
  return {{"length_m", &c.length_m, "full", 1e-3, kMetre},
          {"width_m", &c.width_m, "full", 1e-3, kMetre},
          {"days", &c.days, "from emergence to full size", 0.1, kDays},
          {"fastest_days", &c.fastest_days, "age of the fastest growth", 0, kDays},
          {"size_spread", &c.size_spread, "sigma of one's size", 0, 0.3},
          {"start_share", &c.start_share, "of the size at emergence", 0.01, 1},
          {"open_rad", &c.open_rad, "from the axis when open", 0, kAngle},
          {"open_day", &c.open_day, "age at which half open", 0, kDays},
          {"open_scale_days", &c.open_scale_days, "how fast it opens", 0.01, kDays},
          {"open_spread", &c.open_spread, "sigma of one's opening", 0, 0.3},
          {"least_open_rad", &c.least_open_rad, "from the axis, closed", 0, kAngle},
          {"petiole_m", &c.petiole_m, "length of its stalk", 1e-4, kMetre},
          {"radius_share", &c.radius_share,
           "stalk's base and tip, midrib's tip, over the hypocotyl's tip", 0.01, 2},
          {"droop_rad", &c.droop_rad, "of the tip", -kAngle, kAngle},
          {"young_droop", &c.young_droop, "times droop_rad, before it is old", -5, 5},
          {"old_droop", &c.old_droop, "times droop_rad, when old", -5, 5},
          {"old_after_days", &c.old_after_days, "after open_day: half old", 0, kDays},
          {"old_scale_days", &c.old_scale_days, "how fast it grows old", 0.01, kDays},
          {"camber", &c.camber, "of the margins", -2, 2},
          {"fold_rad", &c.fold_rad, "of the halves about the midrib", -1.5, 1.5},
          {"outline", &c.outline, "base, peak, rise, fall, tip of the envelope", 0, 10},
          {"albedo", &c.albedo, "green", 0, 1},
          {"albedo_young", &c.albedo_young, "before it greens", 0, 1},
          {"albedo_vein", &c.albedo_vein, "of the veins", 0, 1},
          {"albedo_back", &c.albedo_back, "of the lower side's veins", 0, 1},
          {"transmittance", &c.transmittance, "of the lamina", 0, 1},
          {"green_day", &c.green_day, "age at which half green", 0, kDays}};
}

Fields fields(WatermelonConfig::Leaf& c) {
  return {{"plastochron_days", &c.plastochron_days, "between leaves", 0.1, kDays},
          {"first_day", &c.first_day, "age of the plant when the first shows", 0, kDays},
          {"length_m", &c.length_m, "of full blades from the first", 1e-3, kMetre},
          {"least_m", &c.least_m, "shorter blades are still in the bud", 1e-5, 0.1},
          {"counted_m", &c.counted_m, "blades at least this long count as leaves", 0, kMetre},
          {"width_share", &c.width_share, "widest row over the length", 0.05, 3},
          {"size_spread", &c.size_spread, "sigma of one leaf's size", 0, 0.3},
          {"folded_width", &c.folded_width, "width before it unfolds, over after", 0, 1},
          {"days", &c.days, "to full size", 0.1, kDays},
          {"fastest_days", &c.fastest_days, "age of the fastest growth", 0, kDays},
          {"petiole_share", &c.petiole_share, "over the blade's length", 0.01, 5},
          {"petiole_radius_m", &c.petiole_radius_m, "of a full leaf", 1e-5, 0.1},
          {"young_petiole", &c.young_petiole, "least of that radius", 0, 1},
          {"petiole_taper", &c.petiole_taper, "tip's radius over the base's", 0.01, 2},
          {"petiole_rise_rad", &c.petiole_rise_rad, "its turn upwards", -kAngle, kAngle},
          {"internode_radius", &c.internode_radius, "over the hypocotyl's tip", 0.01, 2},
          {"internode_m", &c.internode_m, "full length of the first internodes", 1e-4, kMetre},
          {"divergence_rad", &c.divergence_rad, "from leaf to leaf", 0, 6.3},
          {"spread_rad", &c.spread_rad, "sigma of it", 0, 1},
          {"lobes", &c.lobes, "a side, of each leaf", 0, 20},
          {"lobe_depth", &c.lobe_depth, "of each leaf", 0, 0.95},
          {"lobe_round", &c.lobe_round, "above 1: broad lobes", 0.1, 10},
          {"teeth", &c.teeth, "a side", 0, 100},
          {"teeth_depth", &c.teeth_depth, "of the margin", 0, 0.9},
          {"sweep_base_rad", &c.sweep_base_rad, "of the rows at the base", 0, kAngle},
          {"sweep_tip_rad", &c.sweep_tip_rad, "of the rows at the tip", 0, kAngle},
          {"outline", &c.outline, "base, peak, rise, fall, tip of the envelope", 0, 10},
          {"young_angle_rad", &c.young_angle_rad, "petiole from the axis, young", 0, kAngle},
          {"old_angle_rad", &c.old_angle_rad, "petiole from the axis, old", 0, kAngle},
          {"angle_day", &c.angle_day, "age at which half-way between", 0, kDays},
          {"angle_scale_days", &c.angle_scale_days, "how fast it passes", 0.01, kDays},
          {"angle_spread", &c.angle_spread, "sigma of one petiole's angle", 0, 0.3},
          {"blade_angle_rad", &c.blade_angle_rad, "of the blade from the petiole", -kAngle, kAngle},
          {"young_blade", &c.young_blade, "share of it when the leaf comes", 0, 1},
          {"young_fold_rad", &c.young_fold_rad, "of the halves, young", -1.5, 1.5},
          {"old_fold_rad", &c.old_fold_rad, "of the halves, old", -1.5, 1.5},
          {"unfold_day", &c.unfold_day, "age at which half unfolded", 0, kDays},
          {"unfold_scale_days", &c.unfold_scale_days, "how fast it unfolds", 0.01, kDays},
          {"droop_rad", &c.droop_rad, "of the blade's tip when old", -kAngle, kAngle},
          {"twist_rad", &c.twist_rad, "sigma of the tip's twist", 0, kAngle},
          {"wave_m", &c.wave_m, "of a full blade's margin", 0, 0.1},
          {"folded_wave", &c.folded_wave, "share of it before it unfolds", 0, 1},
          {"quilt_m", &c.quilt_m, "of the lamina between side veins", 0, 0.1},
          {"camber", &c.camber, "of the margins", -2, 2},
          {"albedo", &c.albedo, "of the lamina", 0, 1},
          {"albedo_young", &c.albedo_young, "of a young lamina", 0, 1},
          {"albedo_vein", &c.albedo_vein, "of the veins", 0, 1},
          {"albedo_back", &c.albedo_back, "of the lower side's veins", 0, 1},
          {"transmittance", &c.transmittance, "of the lamina", 0, 1},
          {"midrib_taper", &c.midrib_taper, "tip's radius over the base's", 0.01, 2},
          {"vein_width_m", &c.vein_width_m, "of a full blade's midrib", 1e-5, 0.1}};
}

Fields fields(WatermelonConfig::Surface& c) {
  return {{"detail_m", &c.detail_m, "edge of the triangles of blades", 1e-4, 0.1},
          {"tube_sides", &c.tube_sides, "of stems", 3, 100},
          {"ior", &c.ior, "of the wax", 1, 2},
          {"leaf_roughness", &c.leaf_roughness, "of blades", 0.05, 1},
          {"stem_roughness", &c.stem_roughness, "of stems", 0.05, 1},
          {"infrared_albedo", &c.infrared_albedo, "at 850 nm", 0, 1},
          {"infrared_transmittance", &c.infrared_transmittance, "of blades at 850 nm", 0, 1}};
}

void require_count(const char* key, const std::vector<double>& values, std::size_t count) {
  if (values.size() != count) {
    throw std::invalid_argument("watermelon: " + std::string(key) + " has " +
                                std::to_string(values.size()) + " numbers; it needs " +
                                std::to_string(count));
  }
}

}  // namespace

Fields fields(WatermelonConfig& c) {
  return nested("emergence", fields(c.emergence)) + nested("hypocotyl", fields(c.hypocotyl)) +
         nested("cotyledon", fields(c.cotyledon)) + nested("leaf", fields(c.leaf)) +
         nested("surface", fields(c.surface)) + nested("sway", fields(c.sway)) +
         nested("limbs", fields(c.limbs));
}

void validate(const WatermelonConfig& config) {
  WatermelonConfig copy = config;
  check_limits(fields(copy), "watermelon");
  const auto& h = config.hypocotyl;
  const auto& c = config.cotyledon;
  const auto& l = config.leaf;
  for (const auto& [key, values] : {std::pair{"hypocotyl.albedo", &h.albedo},
                                    {"hypocotyl.albedo_base", &h.albedo_base},
                                    {"cotyledon.albedo", &c.albedo},
                                    {"cotyledon.albedo_young", &c.albedo_young},
                                    {"cotyledon.albedo_vein", &c.albedo_vein},
                                    {"cotyledon.albedo_back", &c.albedo_back},
                                    {"cotyledon.transmittance", &c.transmittance},
                                    {"leaf.albedo", &l.albedo},
                                    {"leaf.albedo_young", &l.albedo_young},
                                    {"leaf.albedo_vein", &l.albedo_vein},
                                    {"leaf.albedo_back", &l.albedo_back},
                                    {"leaf.transmittance", &l.transmittance}})
    require_count(key, *values, 3);
  require_count("cotyledon.radius_share", c.radius_share, 3);
  require_count("cotyledon.outline", c.outline, 5);
  require_count("leaf.outline", l.outline, 5);
  for (const auto& [key, values] : {std::pair{"leaf.length_m", &l.length_m},
                                    {"leaf.lobes", &l.lobes},
                                    {"leaf.lobe_depth", &l.lobe_depth}})
    require_count(key, *values, kSeedlingLeaves);
}

const WatermelonConfig& watermelon() {
  static const WatermelonConfig kConfig = [] {
    WatermelonConfig config;
    read_toml_text(watermelon_toml(), "scenes/seedlings/watermelon.toml", fields(config),
                   MissingKeys::error);
    validate(config);
    return config;
  }();
  return kConfig;
}

}  // namespace cousin
