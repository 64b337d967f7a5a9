#pragma once

#include <string>
#include <vector>

#include "scenes/apples/apple_tree.h"
#include "scenes/apples/orchard.h"
#include "scenes/fruit/rig_eye.h"
#include "sim/config/fields.h"
#include "sim/truth/scene.h"
#include "sim/types/rng.h"

namespace cousin {

struct ApplesSceneConfig {
  int fruits = 85;     ///< on the tree
  double heavier = 1;  ///< times the fruits' masses: what stalks and branches can hold
  std::string family = "botanical";  ///< of the fruits' shapes, or harmonics
  double elongation = 1;             ///< times their length over width
  bool sag = true;                   ///< branches bend under their fruits (MuJoCo)
  int neighbours = 2;                ///< trees of the row whose fruits are specimens too
  int trees = 11;                    ///< a row
  int rows = 3;
  std::string light = "front";                         ///< front, back, side, shade
  int views = 8;                                       ///< each of a fruit of its own
  std::string look = "any";                            ///< up, level, down, any
  double distance_min_m = 0.25, distance_max_m = 1.0;  ///< of the camera from the target's centre
  /// Hidden share of the target; negative: as it comes.
  double occlusion = -1;
  bool turns_leaves = true;     ///< where no camera meets it, leaves near the target are turned
  std::string unmet = "state";  ///< what becomes of a view that misses `occlusion`: state or refuse
  std::string rig = "d455";
  OrchardConfig orchard = cousin::orchard();
  RigEye eye;
};
Fields fields(ApplesSceneConfig& config);
/// @throws std::invalid_argument naming key, value and limit.
void validate(const ApplesSceneConfig& config);

/// A Fuji tree in its row, seen view by view from 0.1 to 1 m of one of its fruits. Fruits of the
/// tree and its neighbours are specimens "apple NNN" with traits and keypoints; each leaf of the
/// tree is an instance. The wood of the tree, instance "tree", carries what is known of the whole
/// and of each view: `target NNNNNN` (instance id), and with occlusion asked for `visible NNNNNN`
/// and `met NNNNNN` (1: within 0.03).
/// @throws std::invalid_argument for fruits that the tree cannot hold, and with unmet = refuse for
/// an occlusion that is not met.
Scene build_apples_scene(const ApplesSceneConfig& config, Rng rng);

/// The tree of the scene alone, fruits hung and leaves cleared; for studies.
struct GrownTree {
  AppleTree tree;
  std::vector<FruitModel> fruits;
  std::vector<PlantModel> leaves;
};
GrownTree grow_scene_tree(const ApplesSceneConfig& config, const Rng& rng);

}  // namespace cousin
