#pragma once

#include <string>
#include <vector>

#include "scenes/row/rig_eye.h"
#include "scenes/row/scene_row.h"
#include "scenes/strawberries/stand_motion.h"
#include "scenes/strawberries/strawberry_bed.h"
#include "scenes/strawberries/strawberry_plant.h"
#include "scenes/strawberries/strawberry_stand.h"
#include "sim/config/fields.h"
#include "sim/truth/scene.h"
#include "sim/types/rng.h"

namespace cousin {

struct StrawberriesSceneConfig {
  StandConfig stand;
  int plants = 200;                   ///< different stretches; scene i shows stretch i % plants
  bool ripens = true;                 ///< each scene has its own colours; false: as it grew
  std::string light = "drawn";        ///< or one of strawberry_lights()
  std::string category = "maturity";  ///< low, medium, high by red share; or variety
  int views = 6;
  double distance_min_m = 0.3, distance_max_m = 0.6;  ///< from the fruits' middle
  double height_m = 0.05;                             ///< eye above or below it, at most
  double tilted_share = 0.5;  ///< of the views, that look down; the others are level
  double pitch_min_rad = 0.17, pitch_max_rad = 0.26;  ///< of those that look down
  double azimuth_spread_rad = 0.6;                    ///< views within this of straight on
  /// Hidden share of the fruit that each view is of; negative: views are of all fruits, as it
  /// comes.
  double occlusion = -1;
  bool swings_leaves = true;    ///< where no camera meets it, leaves near the target are swung
  std::string unmet = "state";  ///< what becomes of a view that misses `occlusion`: state or refuse
  StandWind motion;             ///< what moves trusses and leaves; still by default
  std::string rig = "d457";
  StrawberryPlantConfig plant = strawberry_plant();
  StrawberryBedConfig bed = strawberry_bed();
  /// Folder that keeps stands at rest; empty: none is kept. It changes no byte of what is made.
  std::string cache;
  RigEye eye;
};
/// All but `cache`, which is of the machine, and `eye`.
Fields fields(StrawberriesSceneConfig& config);
/// @throws std::invalid_argument naming key, value and limit.
void validate(const StrawberriesSceneConfig& config);

/// A stretch of raised bed with two rows of plants, trusses of the near row over its edge. World:
/// the bed's top is z = 0, its edge x = 0 with the path on the side +x, rows along y. Fruits are
/// specimens "fruit NN": labels maturity and variety, traits of FruitModel and maturity (0 low,
/// 1 medium, 2 high: see truss.toml), axis_x, axis_y, axis_z (unit, from tip to calyx,
/// in the world), keypoints tip, calyx_centre, cut_point. Plants of the near row are instances
/// "plant NN", parts as grow_strawberry_plant; stalks of a truss "truss NN". With occlusion asked
/// for or in wind, leaves of the near row are instances "plant NN leaf K" of their own. In wind, or
/// under a hand, stalks are instances "truss NN stalk SS piece K" that move as rigid bodies, and
/// fruits and calyces move with their stalks' ends.
/// @param rest  of settle_stand for the same configuration and `plant_rng`
/// @param plant_rng  what grows, the same for all scenes of a stretch
/// @param rng  colours, light and views of this scene
/// @throws std::invalid_argument for a camera in something, an occlusion that is not met and to be
/// refused; std::runtime_error where wind or a hand breaks a stalk.
Scene build_strawberries_scene(const StrawberriesSceneConfig& config, const StandRest& rest,
                               const Rng& plant_rng, const Rng& rng);

/// Views of fruits: level or looking down, at the height of their middle.
std::vector<View> strawberry_views(const StrawberriesSceneConfig& config,
                                   const Eigen::Vector3d& middle_m, Rng rng);

/// Class of a red share by truss.toml: 0 low, 1 medium, 2 high.
int maturity_of(double red_share);

/// Deepest that a scene's plants (leaves, petioles, flowers, runners) reach into its fruits' hulls;
/// negative: the least distance from them, or -0.01.
double plants_in_fruits_m(const Scene& scene);
/// The same of sepals in the fruits beside theirs.
double sepals_in_fruits_m(const Scene& scene);

// ---- Its row -----------------------------------------------------------------------------------

Scene build_scene(const StrawberriesSceneConfig& config, const SceneBuild& which);
void see(StrawberriesSceneConfig& config, const RigSight& sight);
std::vector<std::string> shared_plants(const StrawberriesSceneConfig& config, int index);
std::vector<std::string> specimen_categories(const StrawberriesSceneConfig& config);
std::string* cache_folder(StrawberriesSceneConfig& config);
PhysicsUse physics_of(const StrawberriesSceneConfig& config);

/// The stream of a stretch: what grows on it.
Rng stretch_rng(std::uint64_t seed, int plant);
/// All that decides stretch number `plant` of a run at rest.
std::string stand_key(const StrawberriesSceneConfig& config, std::uint64_t seed, int plant);
/// It at rest: as `rests` keeps it, or settled, and then kept. The same bytes either way.
/// @param rests  null: nothing is kept
/// @throws std::runtime_error naming the file, what in it is wrong and the limit if it is damaged
/// or of another stretch; and as settle_stand.
StandRest stand_at_rest(const StrawberriesSceneConfig& config, std::uint64_t seed, int plant,
                        const RestStore* rests);
const SceneRow& strawberries_row();
const SceneRow& row_of(const StrawberriesSceneConfig& config);

}  // namespace cousin
