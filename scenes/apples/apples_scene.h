#pragma once

#include <string>
#include <vector>

#include "scenes/apples/apple_cultivar.h"
#include "scenes/apples/apple_tree.h"
#include "scenes/apples/orchard.h"
#include "scenes/row/rig_eye.h"
#include "scenes/row/scene_row.h"
#include "sim/config/fields.h"
#include "sim/physics/wind.h"
#include "sim/truth/scene.h"
#include "sim/types/rng.h"

namespace cousin {

struct ApplesSceneConfig {
  int fruits = 64;     ///< on the tree; 50 to 60 leaves each [Koike 1999, in orchard.toml]
  double heavier = 1;  ///< times the fruits' masses: what stalks and branches can hold
  std::string family = "botanical";  ///< of the fruits' shapes, or harmonics
  double elongation = 1;             ///< times their length over width
  bool sag = true;                   ///< branches bend under their fruits (MuJoCo)
  int neighbours = 2;                ///< trees of the row whose fruits are specimens too
  int trees = 31;                    ///< a row
  int rows = 7;
  std::string light = "front";  ///< front, back, side, shade
  int views = 8;                ///< each of a fruit of its own
  /// up, level, down or any at single fruits; tree: from both alleys at the whole tree
  std::string look = "any";
  double distance_min_m = 0.25, distance_max_m = 1.0;  ///< of the camera from the target's centre
  /// Hidden share of the target; negative: as it comes.
  double occlusion = -1;
  bool turns_leaves = true;     ///< where no camera meets it, leaves near the target are turned
  std::string unmet = "state";  ///< what becomes of a view that misses `occlusion`: state or refuse
  WindConfig wind;              ///< in which branches sway; still by default
  BranchPush push;
  std::string rig = "d455";
  /// Folder that keeps branches at rest; empty: none. It decides nothing, and is no key of the
  /// scene.
  std::string cache;
  OrchardConfig orchard = cousin::orchard();
  AppleCultivar fuji = apple_cultivar("fuji");
  RigEye eye;
};
Fields fields(ApplesSceneConfig& config);
/// @throws std::invalid_argument naming key, value and limit.
void validate(const ApplesSceneConfig& config);

/// A Fuji tree in its row, seen view by view from 0.1 to 1 m of one of its fruits, or whole from
/// both alleys in turns. Fruits of the
/// tree and its neighbours are specimens "apple NNN" of their maturity as category, with labels
/// maturity (low, medium, high: see cultivars.toml) and variety, traits and keypoints; each leaf of
/// the tree is an instance. The wood of the tree, instance "tree", carries what is known of the
/// whole and of each view of a fruit: `target NNNNNN` (instance id), and with occlusion asked for
/// `visible NNNNNN` and `met NNNNNN` (1: within 0.03).
/// @throws std::invalid_argument for fruits that the tree cannot hold, and with unmet = refuse for
/// an occlusion that is not met.
/// In wind, or under a hand, branches with all they carry move about the times of the views, each
/// section's wood an instance of its own; `visible` and `met` are of the tree at rest.
/// @param settle  how branches come to rest
Scene build_apples_scene(const ApplesSceneConfig& config, Rng rng,
                         const BranchSettler& settle = settle_branches);

/// The tree of the scene alone, fruits hung and leaves cleared; for studies.
struct GrownTree {
  AppleTree tree;
  std::vector<FruitModel> fruits;
  std::vector<PlantModel> leaves;
};
GrownTree grow_scene_tree(const ApplesSceneConfig& config, const Rng& rng,
                          const BranchSettler& settle = settle_branches);

/// Branches at rest as text, and all keys that decide them: for files that keep them.
std::string rests_to_text(const std::vector<SagResult>& rests);
/// @param branches  whose rests they are @param name  of the file
/// @throws std::runtime_error naming the file, what stands in it and what must.
std::vector<SagResult> rests_from_text(std::string_view text, const std::string& name,
                                       const std::vector<HangingBranch>& branches);
std::string description_of_tree(const ApplesSceneConfig& config);

// ---- Its row -----------------------------------------------------------------------------------

Scene build_scene(const ApplesSceneConfig& config, const SceneBuild& which);
void see(ApplesSceneConfig& config, const RigSight& sight);
std::vector<std::string> specimen_categories(const ApplesSceneConfig& config);
std::string* cache_folder(ApplesSceneConfig& config);
PhysicsUse physics_of(const ApplesSceneConfig& config);

/// All that decides the branches of a run's tree at rest.
std::string tree_key(const ApplesSceneConfig& config, const SceneBuild& which);
/// Branches at rest: those that `which` keeps, or settled, and then kept.
BranchSettler tree_settler(const ApplesSceneConfig& config, const SceneBuild& which);
const SceneRow& apples_row();
const SceneRow& row_of(const ApplesSceneConfig& config);

}  // namespace cousin
