#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/config/fields.h"
#include "sim/truth/scene.h"
#include "sim/types/rng.h"

namespace cousin {

/// tray.toml, which says what each number is. Every value is given there.
struct TrayConfig {
  struct Tray {
    int columns = 0, rows = 0;
    double pitch_m = 0, depth_m = 0, wall_m = 0, corner = 0, taper = 0;
    std::vector<double> albedo;
    double roughness = 0, empty_share = 0;
  } tray;
  struct Substrate {
    double below_rim_m = 0;
    int variants = 0;
    double detail_m = 0, clump_m = 0, clump_scale_m = 0, grain_m = 0, grain_scale_m = 0;
    std::vector<double> albedo_dark, albedo_light;
    int perlite = 0;
    std::vector<double> perlite_m, perlite_albedo;
    double roughness = 0;
  } substrate;
  struct Bench {
    double half_m = 0;
    std::vector<double> albedo, other_albedo;
    double noise_m = 0;
  } bench;
  struct LightNumbers {
    double d1_elevation_rad = 0, d1_azimuth_rad = 0, d1_turbidity = 0;
    std::vector<double> d2_zenith;
    double d2_horizon_share = 0;
    int d3_lamps = 0;
    double d3_height_m = 0, d3_half_length_m = 0, d3_half_width_m = 0, d3_radiance = 0;
    double d3_blue_m = 0, d3_red_m = 0, d3_width_m = 0, d3_blue_share = 0;
    std::vector<double> d3_room;
  } light;
};
Fields fields(TrayConfig& config);
/// @throws std::invalid_argument naming key, value and limit.
void validate(const TrayConfig& config);
const TrayConfig& seedling_tray();  ///< of tray.toml

/// Middle of a cell on the substrate's surface, in the world: the tray's middle is the origin, its
/// length along x; cell 0 has the least x and y, and numbers run along x first.
Eigen::Vector3d cell_in_world_m(const TrayConfig& config, int cell);

/// The floor, the tray with its walls, and each cell's substrate as an instance "cell NN" of its
/// own, whose place in scene.instances is the cell's number after `first`.
/// @return first
int add_tray(Scene& scene, const TrayConfig& config, Rng rng);

/// @param light  D1 strong sun, D2 overcast, D3 violet LED. @throws std::invalid_argument for
/// another.
void add_seedling_light(Scene& scene, const TrayConfig& config, const std::string& light);
/// Where most of a light comes from, unit: what seedlings bend to.
Eigen::Vector3d to_light(const TrayConfig& config, const std::string& light);

}  // namespace cousin
