#pragma once

#include <string>
#include <vector>

#include "scenes/seeds/seeds_scene.h"

namespace cousin {

/// setting.toml, which says what each number is. Every value is given there.
struct SettingConfig {
  double board_thickness_m = 0, board_cell_m = 0;
  std::vector<double> paper_albedo, ink_albedo;
  double board_roughness = 0, board_ior = 0;
  double screen_radius_m = 0, screen_wall_m = 0;
  std::vector<double> screen_albedo, screen_white, screen_black, screen_wood;
  double sphere_radius_m = 0;
  int sphere_grid = 0;
  std::vector<double> sphere_albedo;
  double sphere_speckle = 0, sphere_speckle_scale_m = 0;
  double specimen_density_kg_m3 = 0;
  std::vector<double> specimen_albedo;
  double specimen_mottle = 0, specimen_mottle_scale_m = 0;
  double spot_radius_m = 0, spot_gap_m = 0, rest_gap_m = 0, reach_m = 0, drop_height_m = 0;
  int attempts = 0;
  double heap_friction = 0, heap_rolling_friction_m = 0;
  double heap_drag_per_s = 0, heap_time_s = 0, heap_rest_energy_j = 0, heap_penetration_m = 0;
};
Fields fields(SettingConfig& config);
void validate(const SettingConfig& config);
const SettingConfig& seeds_setting();

/// A sheet bent about the board's y axis: a parabola whose mean height over the plate is 0.
struct SheetShape {
  double sag_m = 0;      ///< the edges at +-x are higher than the middle by so much
  double half_m = 0.05;  ///< of the plate's side
  double height_m(double x_m) const {
    const double x = x_m / half_m;
    return sag_m * (x * x - 1.0 / 3);
  }
};

/// The plate with its print on z = 0, bent as the sheet is, and its material.
void add_board(Scene& scene, const SettingConfig& setting, const SeedBoard& board,
               const SheetShape& sheet);
/// @param background  as SeedsSceneConfig's. @throws std::invalid_argument naming those that exist.
const std::vector<double>& background_albedo(const SettingConfig& setting,
                                             const std::string& background);
/// Floor of the background's colour at the plate's underside with a low wall around, open above so
/// that the sky lights the scene.
void add_screen(Scene& scene, const SettingConfig& setting, const std::string& background);
/// @param light  window, lamps or sun. @throws std::invalid_argument for another.
void add_lights(Scene& scene, const std::string& light);
/// The 22 mm sphere, matt with speckle, at its centroid.
SeedModel make_sphere(const SettingConfig& setting, Rng rng);
/// Mottled colour of one hue, for meshes without their own.
std::vector<Rgbf> mottle(const Mesh& mesh, const std::vector<double>& albedo, double contrast,
                         double scale_m, Rng rng);

/// `views` poses on three rings around the board, hand-held: distances wander within the limits,
/// every view looks near the centre. View i is the same for the same rng whatever `views` is only
/// if `views` is the same.
std::vector<View> camera_path(const SeedsSceneConfig& config, Rng rng);

}  // namespace cousin
