#pragma once

#include <vector>

#include "scenes/limbs/plant_limbs.h"
#include "sim/config/fields.h"
#include "sim/physics/rigid_sway.h"
#include "sim/plant/plant.h"
#include "sim/types/rng.h"

namespace cousin {

/// watermelon.toml, which says what each number is and where it comes from. Every value is given
/// there.
struct WatermelonConfig {
  struct Emergence {
    double day = 0, spread_days = 0, failed_share = 0, spread = 0;
  } emergence;
  struct Hypocotyl {
    double length_m = 0, start_m = 0, radius_base_m = 0, radius_tip_m = 0, days = 0,
           fastest_days = 0;
    double section_gain = 0, light_days = 0, light_begin = 0;
    double hook_rad = 0, hook_day = 0, hook_scale_days = 0, hook_begin = 0;
    double light_rad = 0, lean_rad = 0, depth_m = 0;
    std::vector<double> albedo, albedo_base;
  } hypocotyl;
  struct Cotyledon {
    double length_m = 0, width_m = 0, days = 0, fastest_days = 0, start_share = 0;
    double open_rad = 0, open_day = 0, open_scale_days = 0;
    double petiole_m = 0, droop_rad = 0, camber = 0, fold_rad = 0;
    double size_spread = 0, open_spread = 0, least_open_rad = 0;
    double old_after_days = 0, old_scale_days = 0, young_droop = 0, old_droop = 0;
    std::vector<double> radius_share;
    std::vector<double> outline;
    std::vector<double> albedo, albedo_young, albedo_vein, albedo_back, transmittance;
    double green_day = 0;
  } cotyledon;
  struct Leaf {
    double plastochron_days = 0, first_day = 0;
    std::vector<double> length_m;
    double least_m = 0, counted_m = 0, width_share = 0, days = 0, fastest_days = 0;
    double petiole_share = 0, petiole_radius_m = 0, internode_m = 0;
    double divergence_rad = 0, spread_rad = 0;
    std::vector<double> lobes, lobe_depth;
    double lobe_round = 0;
    int teeth = 0;
    double teeth_depth = 0, sweep_base_rad = 0, sweep_tip_rad = 0;
    std::vector<double> outline;
    double young_angle_rad = 0, old_angle_rad = 0, young_fold_rad = 0, old_fold_rad = 0;
    double angle_day = 0, blade_angle_rad = 0;
    double unfold_day = 0, unfold_scale_days = 0, droop_rad = 0;
    double wave_m = 0, quilt_m = 0, camber = 0;
    double size_spread = 0, angle_spread = 0, twist_rad = 0, angle_scale_days = 0;
    double folded_width = 0, folded_wave = 0, young_blade = 0;
    double midrib_taper = 0, internode_radius = 0, young_petiole = 0, petiole_taper = 0;
    double petiole_rise_rad = 0;
    std::vector<double> albedo, albedo_young, albedo_vein, albedo_back, transmittance;
    double vein_width_m = 0;
  } leaf;
  struct Surface {
    double detail_m = 0;
    int tube_sides = 0;
    double ior = 0, leaf_roughness = 0, stem_roughness = 0;
    double infrared_albedo = 0, infrared_transmittance = 0;
  } surface;
  RigidSwayConfig sway;  ///< of whole plants
  LimbConfig limbs;
};
Fields fields(WatermelonConfig& config);
/// @throws std::invalid_argument naming key, value and limit.
void validate(const WatermelonConfig& config);
const WatermelonConfig& watermelon();  ///< of watermelon.toml

/// Days since sowing that seedlings are grown for; numbers beyond day 12 are extrapolated.
inline constexpr double kLastSeedlingDay = 20;
inline constexpr int kSeedlingLeaves = 4;  ///< at most

/// Looks of a seedling's organs, in the order of watermelon_materials().
enum SeedlingLook { kStemLook, kCotyledonLook, kLeafLook };
std::vector<Material> watermelon_materials(const WatermelonConfig& config);

/// What is around a seedling.
struct SeedlingPlace {
  Eigen::Vector3d to_light = Eigen::Vector3d::UnitZ();  ///< unit
  int leaves = kSeedlingLeaves;  ///< true leaves that it may ever have, 0 .. kSeedlingLeaves
};

struct Seedling {
  bool germinates = false;
  double emergence_day = 0;
  bool has_emerged = false;  ///< on that day
  Plant plant;               ///< all organs that it will ever have; collar at the origin
  std::vector<TrueTrait> traits;
};
/// One plant on one day: deterministic in (config, place, rng), whatever the day; so the same rng
/// is the same plant on every day. Organs, in this order: hypocotyl, two cotyledons with their
/// petioles, then internode, petiole and blade of each leaf.
/// @param day  since sowing. @throws std::invalid_argument if it is not in [0, kLastSeedlingDay].
Seedling grow_watermelon(const WatermelonConfig& config, const SeedlingPlace& place, double day,
                         Rng rng);

}  // namespace cousin
