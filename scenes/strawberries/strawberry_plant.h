#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sim/config/fields.h"
#include "sim/physics/rigid_sway.h"
#include "sim/plant/plant.h"
#include "sim/types/rng.h"

namespace cousin {

class LeafCrowd;

/// plant.toml, which says what each number is and where it comes from. Every value is given there.
struct StrawberryPlantConfig {
  struct Crown {
    double radius_m = 0, height_m = 0;
    std::vector<double> albedo;
  } crown;
  struct Leaf {
    int count_min = 0, count_max = 0;
    double divergence_rad = 0, spread_rad = 0, petiole_m = 0, cv_length = 0, petiole_radius_m = 0;
    double young_rad = 0, old_rad = 0, sag_rad = 0, lean_rad = 0, size_youngest = 0;
    double hang_rad = 0, reach = 0;
    double leaflet_m = 0, width_share = 0, side_share = 0, side_rad = 0, petiolule_m = 0;
    double droop_young_rad = 0, droop_old_rad = 0, curl_rad = 0, fold_young_rad = 0, fold_rad = 0;
    double roll_rad = 0, camber = 0, wave_m = 0, quilt_m = 0;
    int veins = 0, teeth = 0;
    double teeth_depth = 0;
    std::vector<double> outline;
    double sweep_base_rad = 0, sweep_tip_rad = 0, vein_width_m = 0;
    std::vector<double> albedo, albedo_young, albedo_old, albedo_vein, albedo_back, transmittance;
    std::vector<double> petiole_albedo;
    double foot_share = 0, grown_age = 0, open_age = 0;
    double vigour_spread = 0, size_spread = 0, angle_spread_rad = 0, droop_spread_rad = 0;
    double angle_power = 0, droop_power = 0, young_petiole = 0, opening_width = 0, folded_side = 0;
    double hang_least = 0, hang_blade = 0, sag_begin = 0, side_roll = 0, curl_begin = 0;
    double wave_count = 0;
    std::vector<double> petiole_thick;
  } leaf;
  struct Flower {
    double mean = 0, stalk_m = 0, stalk_radius_m = 0, stalk_rad = 0;
    double length_spread = 0, angle_spread = 0, stalk_sag_rad = 0, sag_begin = 0;
    double facing_up = 0, facing_out = 0;
    std::vector<double> stalk_thick;
    double petal_m = 0, sepal_m = 0, receptacle_m = 0;
    int anthers = 0;
    std::vector<double> albedo_petal, transmittance_petal, albedo_receptacle, albedo_anther;
  } flower;
  struct Runner {
    double share = 0, length_m = 0, radius_m = 0, leaf_share = 0;
    double length_spread = 0, azimuth_rad = 0, divergence_rad = 0;
    std::vector<double> rise, sag_rad;
    std::vector<double> albedo;
  } runner;
  struct Surface {
    int rows = 0, columns = 0, sides = 0;
    double ior = 0, leaf_roughness = 0, stem_roughness = 0;
    double infrared_albedo = 0, infrared_transmittance = 0, clear_m = 0;
    int tries = 0;
  } surface;
  RigidSwayConfig sway;  ///< of a leaf about the base of its petiole
};
Fields fields(StrawberryPlantConfig& config);
/// @throws std::invalid_argument naming key, value and limit.
void validate(const StrawberryPlantConfig& config);
const StrawberryPlantConfig& strawberry_plant();  ///< of plant.toml

/// Looks of a plant's organs, in the order of strawberry_materials().
enum StrawberryLook {
  kBerryStalkLook,
  kBerryLeafletLook,
  kBerryPetalLook,
  kBerryReceptacleLook,
  kBerryCrownLook
};
std::vector<Material> strawberry_materials(const StrawberryPlantConfig& config);

/// Whether a part of a plant, in the plant's frame, touches nothing that it must keep off.
using IsFree = std::function<bool(const Mesh& part)>;

/// A plant without its trusses: its crown at the origin, z up, the path on the side +x. Organs:
/// crown; of each of leaf.count_max leaves, the oldest first, petiole and three leaflets; of three
/// flowers stalk, petals, sepals and middle; a runner with a daughter of three leaves. A leaf,
/// flower or runner for which no pose is free is not there. Leaves that grow on the crown pass
/// through none of those before them. Deterministic in (config, is_free, rng, crowd).
/// @param crowd  leaflets of plants that stand already, in the frame of a plant at `at_m`; the new
/// ones join it. None: the plant is alone.
Plant grow_strawberry_plant(const StrawberryPlantConfig& config, const IsFree& is_free, Rng rng,
                            LeafCrowd* crowd = nullptr,
                            const Eigen::Vector3d& at_m = Eigen::Vector3d::Zero());

}  // namespace cousin
