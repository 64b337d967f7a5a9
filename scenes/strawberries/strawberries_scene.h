#pragma once

#include <string>
#include <vector>

#include "scenes/strawberries/strawberry_bed.h"
#include "scenes/strawberries/strawberry_plant.h"
#include "scenes/strawberries/strawberry_stand.h"
#include "sim/config/fields.h"
#include "sim/truth/scene.h"
#include "sim/types/rng.h"

namespace cousin {

struct StrawberriesSceneConfig {
  StandConfig stand;
  int plants = 200;                  ///< different stretches; scene i shows stretch i % plants
  bool ripens = true;                ///< each scene has its own colours; false: as it grew
  std::string light = "drawn";       ///< or one of strawberry_lights()
  std::string category = "variety";  ///< or maturity: low, medium, high by red share
  int views = 6;
  double distance_min_m = 0.3, distance_max_m = 0.6;  ///< from the fruits' middle
  double height_m = 0.05;                             ///< eye above or below it, at most
  double tilted_share = 0.5;  ///< of the views, that look down; the others are level
  double pitch_min_rad = 0.17, pitch_max_rad = 0.26;  ///< of those that look down
  double azimuth_spread_rad = 0.6;                    ///< views within this of straight on
  std::string rig = "d457";
  StrawberryPlantConfig plant = strawberry_plant();
  StrawberryBedConfig bed = strawberry_bed();
  /// Folder that keeps stands at rest; empty: none is kept. It changes no byte of what is made.
  std::string cache;
};
/// All but `cache`, which is of the machine.
Fields fields(StrawberriesSceneConfig& config);
/// @throws std::invalid_argument naming key, value and limit.
void validate(const StrawberriesSceneConfig& config);

/// A stretch of raised bed with two rows of plants, trusses of the near row over its edge. World:
/// the bed's top is z = 0, its edge x = 0 with the path on the side +x, rows along y. Fruits are
/// specimens "fruit NN": traits of FruitModel and maturity (0 low, 1 medium, 2 high: red share
/// below 0.3, to 0.8, above [Strawberries 2.1]), axis_x, axis_y, axis_z (unit, from tip to calyx,
/// in the world), keypoints tip, calyx_centre, cut_point. Plants of the near row are instances
/// "plant NN", parts as grow_strawberry_plant; stalks of a truss "truss NN".
/// @param rest  of settle_stand for the same configuration and `plant_rng`
/// @param plant_rng  what grows, the same for all scenes of a stretch
/// @param rng  colours, light and views of this scene
Scene build_strawberries_scene(const StrawberriesSceneConfig& config, const StandRest& rest,
                               const Rng& plant_rng, const Rng& rng);

/// Views of fruits: level or looking down, at the height of their middle.
std::vector<View> strawberry_views(const StrawberriesSceneConfig& config,
                                   const Eigen::Vector3d& middle_m, Rng rng);

/// Class of a red share: 0 low, 1 medium, 2 high [Strawberries 2.1].
int maturity_of(double red_share);

/// Deepest that a scene's plants (leaves, petioles, flowers, runners) reach into its fruits' hulls;
/// negative: the least distance from them, or -0.01.
double plants_in_fruits_m(const Scene& scene);

}  // namespace cousin
