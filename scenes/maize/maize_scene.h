#pragma once

#include <string>
#include <vector>

#include "scenes/limbs/scene_wind.h"
#include "scenes/maize/maize_plant.h"
#include "scenes/row/scene_row.h"
#include "sim/config/fields.h"
#include "sim/truth/scene.h"
#include "sim/types/rng.h"

namespace cousin {

struct MaizeSceneConfig {
  std::string stage = "V10";  ///< V3 .. V18, VT
  int rows = 1;               ///< of the field
  int plants = 1;             ///< a row
  std::string light = "sun";  ///< sun or overcast
  int views = 12;
  double distance_min_m = 0.9, distance_max_m = 1.5;  ///< from the stalk of the middle plant
  double height_min = 0.25, height_max = 0.6;  ///< of the point looked at, over the plant's height
  double pitch_min_rad = -0.05, pitch_max_rad = 0.35;  ///< looking down
  double azimuth_spread_rad = 3.14159;  ///< views within this of the direction across the rows
  SceneWind motion;                     ///< what moves the plants; still by default
  std::string rig = "zed_hd720";
  MaizeConfig plant = maize();
};
Fields fields(MaizeSceneConfig& config);
/// @throws std::invalid_argument naming key, value and limit.
void validate(const MaizeSceneConfig& config);

/// A plant, or rows of them, at one stage. The middle plant stands at the origin; rows run along x.
/// Every plant is a specimen of category "maize"; where there are more than field.variants plants,
/// they share meshes, each turned its own way.
Scene build_maize_scene(const MaizeSceneConfig& config, Rng rng);

/// Views of the middle plant. @param height_m  of that plant
std::vector<View> maize_views(const MaizeSceneConfig& config, double height_m, Rng rng);

// ---- Its row -----------------------------------------------------------------------------------

Scene build_scene(const MaizeSceneConfig& config, const SceneBuild& which);
std::vector<std::string> specimen_categories(const MaizeSceneConfig& config);
const SceneRow& maize_row();
const SceneRow& row_of(const MaizeSceneConfig& config);

}  // namespace cousin
