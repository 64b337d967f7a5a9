#pragma once

#include <string>
#include <vector>

#include "scenes/limbs/scene_wind.h"
#include "scenes/row/scene_row.h"
#include "scenes/seedlings/tray.h"
#include "scenes/seedlings/watermelon.h"
#include "sim/config/fields.h"
#include "sim/truth/scene.h"
#include "sim/types/rng.h"

namespace cousin {

struct SeedlingsSceneConfig {
  double day = 8;  ///< since germinated seeds were sown
  double day_step =
      0;  ///< scene i shows day + i * day_step of one tray; 0: each scene its own tray
  int leaves = kSeedlingLeaves;                       ///< true leaves that a plant may ever have
  std::string light = "D1";                           ///< D1 strong sun, D2 overcast, D3 violet LED
  int views = 30;                                     ///< photographs by hand
  double distance_min_m = 0.2, distance_max_m = 0.5;  ///< from the substrate
  double tilt_min_rad = 0.5236, tilt_max_rad = 1.5708;  ///< of the view, 90 degrees = straight down
  /// 1: views lie evenly all around and over the whole tray; less: on that share of the azimuths
  /// and of the tray alone, so that random gaps open; 0: all from one side at one cell.
  double coverage = 1;
  SceneWind motion;  ///< what moves the plants; still by default
  std::string rig = "phone_video_720p";
  WatermelonConfig plant = watermelon();
  TrayConfig setting = seedling_tray();
};
Fields fields(SeedlingsSceneConfig& config);
/// @throws std::invalid_argument naming key, value and limit.
void validate(const SeedlingsSceneConfig& config);

/// A tray of seedlings on a day. Plants that have emerged are specimens "seedling NN" of category
/// "watermelon", NN the cell; each cell's substrate carries the cell's traits, whether anything
/// grows there or not. The same rng is the same tray on every day.
Scene build_seedlings_scene(const SeedlingsSceneConfig& config, Rng rng);

/// Hand-held photographs: distance, tilt, azimuth and the point looked at are drawn at random, in
/// strata where coverage is 1.
std::vector<View> seedling_views(const SeedlingsSceneConfig& config, Rng rng);

// ---- Its row -----------------------------------------------------------------------------------

Scene build_scene(const SeedlingsSceneConfig& config, const SceneBuild& which);
std::vector<std::string> specimen_categories(const SeedlingsSceneConfig& config);
std::vector<std::string> shared_plants(const SeedlingsSceneConfig& config, int index);
bool is_series(const SeedlingsSceneConfig& config);
const SceneRow& seedlings_row();
const SceneRow& row_of(const SeedlingsSceneConfig& config);

}  // namespace cousin
