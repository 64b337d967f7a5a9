#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "scenes/strawberries/truss.h"
#include "sim/config/fields.h"
#include "sim/truth/scene.h"
#include "sim/types/rng.h"

namespace cousin {

/// bed.toml, which says what each number is and where it comes from. Every value is given there.
struct StrawberryBedConfig {
  struct Film {
    std::vector<double> albedo;
    double roughness = 0, ior = 0, wrinkle_m = 0, wrinkle_scale_m = 0, half_length_m = 0;
    double cell_m = 0;
    std::vector<double> dust_albedo;
    double dust_m = 0;
  } film;
  struct Row {
    double spacing_m = 0, scatter_m = 0;
    int plants = 0, variants = 0;
    double hole_m = 0;
    std::vector<double> soil_albedo, soil_other_albedo;
  } row;
  struct Drip {
    double radius_m = 0;
    std::vector<double> albedo;
    double under_m = 0, rise_m = 0;
  } drip;
  struct Path {
    std::vector<double> albedo, other_albedo;
    double weave_m = 0, wave_m = 0, wave_scale_m = 0, lift_m = 0, pitch_m = 0;
    double clod_m = 0, clod_scale_m = 0;
    int beds = 0;
    double wall_m = 0;
    std::vector<double> wall_albedo;
  } path;
  struct LightNumbers {
    double morning_elevation_rad = 0, morning_haze_rad = 0, morning_turbidity = 0;
    double noon_elevation_rad = 0, noon_turbidity = 0, azimuth_spread_rad = 0;
    std::vector<double> overcast;
    double overcast_horizon = 0, lamp_radiance = 0;
    std::vector<double> lamp_half_m;
    double lamp_dim = 0;
  } light;
};
Fields fields(StrawberryBedConfig& config);
/// @throws std::invalid_argument naming key, value and limit.
void validate(const StrawberryBedConfig& config);
const StrawberryBedConfig& strawberry_bed();  ///< of bed.toml

/// Place of crown `k` of a row, 0 .. row.plants - 1, the middle one near y = 0.
/// @param near  the row on the path's side, over whose edge trusses hang
Eigen::Vector3d crown_in_world_m(const StrawberryBedConfig& config, const TrussShape& shape, int k,
                                 bool near, const Rng& rng);

/// Film over the bed, its drip tubes, soil in planting holes about `crowns_m`, path, beds behind,
/// wall; their instances come first. Folds go into the bed only: nothing but the rise over drip
/// tubes stands out of what trusses hang over.
void add_strawberry_bed(Scene& scene, const StrawberryBedConfig& config, const TrussShape& shape,
                        const std::vector<Eigen::Vector3d>& crowns_m, Rng rng);

/// Names of add_strawberry_light.
std::vector<std::string> strawberry_lights();
/// The light's direction where it has a sun, else the zenith; unit.
Eigen::Vector3d to_strawberry_light(const StrawberryBedConfig& config, const std::string& light,
                                    Rng rng);
/// @param light  morning (low sun, softened by the greenhouse), overcast, noon (hard sun) or lamp
/// (dim day and a panel beside the camera)
/// @param eye_m, aim_m  of the camera that the lamp is beside
/// @throws std::invalid_argument naming those that exist.
void add_strawberry_light(Scene& scene, const StrawberryBedConfig& config, const std::string& light,
                          const Eigen::Vector3d& eye_m, const Eigen::Vector3d& aim_m, Rng rng);

}  // namespace cousin
