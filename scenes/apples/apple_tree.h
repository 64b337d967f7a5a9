#pragma once

#include <functional>
#include <string>
#include <vector>

#include "scenes/apples/orchard.h"
#include "scenes/fruit/fruit_model.h"
#include "sim/physics/plant_motion.h"
#include "sim/plant/centre_line.h"
#include "sim/plant/plant.h"
#include "sim/truth/scene.h"
#include "sim/types/rng.h"

namespace cousin {

enum class WoodKind { trunk, branch, spur, shoot };

/// A piece of wood with its centre line, in the tree's frame: foot of the trunk at the origin, z
/// up.
struct WoodAxis {
  WoodKind kind = WoodKind::trunk;
  int parent = -1;          ///< place in AppleTree::wood; -1 = the ground
  double parent_share = 0;  ///< of the parent's length
  CentreLine line;
  bool is_pruned = false;  ///< taken out: it stood where a fruit came to hang
};

/// A leaf of one of the tree's leaf models.
struct LeafPlace {
  int axis = 0;      ///< that it grows on
  double share = 0;  ///< of the axis' length
  int variant = 0;
  Pose tree_from_leaf;  ///< base of the petiole; +x to the tip, +z its upper side
};

/// A fruit of one of the tree's fruit models, tied to a spur's end by its stalk.
struct FruitPlace {
  int axis = 0;  ///< the spur
  int variant = 0;
  double mass_kg = 0;
  Pose tree_from_fruit;
  int load = -1;  ///< of the AppleTree::branches that its spur is on, once it hangs
};

/// A branch with what hangs on it, as physics bends it.
struct HangingBranch {
  int axis = 0;
  std::vector<int> spurs;    ///< axes that bear; stem 1 + k of the plant
  std::vector<int> fruits;   ///< load k hung FruitPlace fruits[k], on stem 1 + spurs + k
  std::vector<int> carried;  ///< axes that are moved with it, the spurs that bear among them
  BendingPlant plant;        ///< unbent, in the tree's frame; stem 0 is the branch
  BentPlant rest;            ///< how it came to hang; no sections where nothing bent it
};

/// How a tree came to hang.
struct TreeRest {
  bool is_bent = false;  ///< false: built without MuJoCo; branches keep their unloaded shape
  int branches = 0;      ///< that physics bends
  int not_at_rest = 0;   ///< of them
  int thinned = 0;       ///< fruits taken off because they came to lie in wood or another fruit
  double deepest_m = 0;  ///< overlap of fruits with fruits and wood that is left; negative: a gap
  double sag_m = 0;      ///< farthest way of a branch's tip
  double stress_ratio = 0;  ///< largest over strength
};

struct AppleTree {
  std::vector<WoodAxis> wood;  ///< parents before children
  std::vector<LeafPlace> leaves;
  std::vector<FruitPlace> fruits;
  std::vector<HangingBranch> branches;  ///< once its fruits hang
  TreeRest rest;
};

/// Which section of what bends carries a thing: none for what the trunk bears.
struct BranchPlace {
  int branch = -1;  ///< place in AppleTree::branches
  int stem = 0;
  double share = 0;
};
/// Of what grows on an axis at a share of its length.
BranchPlace place_on_branch(const AppleTree& tree, int axis, double share);
/// Of a fruit that hangs.
BranchPlace place_on_branch(const AppleTree& tree, const FruitPlace& fruit);

/// How branches come to rest: by physics, or as a file has kept it.
using BranchSettler = std::function<std::vector<SagResult>(const std::vector<HangingBranch>&)>;
/// By MuJoCo, each by itself, in parallel.
std::vector<SagResult> settle_branches(const std::vector<HangingBranch>& branches);

/// The leafy tree without fruits, unbent. @param leaf_variants  models that leaves are drawn from
AppleTree grow_apple_tree(const OrchardConfig& config, int leaf_variants, Rng rng);

/// Hangs `count` fruits on spurs, in clusters of one to three, straight below their stalks and
/// clear of wood and each other. @param heavier  times the models' masses
/// @throws std::invalid_argument naming the fruits asked for and those that the tree has room for,
/// or a fruit whose weight its stalk does not hold.
void bear_fruits(AppleTree& tree, const OrchardConfig& config,
                 const std::vector<FruitModel>& models, int count, double heavier, Rng rng);

/// The same with as many of them as there is room for.
void bear_at_most(AppleTree& tree, const OrchardConfig& config,
                  const std::vector<FruitModel>& models, int count, double heavier, Rng rng);

/// Bends the branches under their fruits to rest as `settle` has them; without `bends` or MuJoCo
/// they stay. Then what overlaps by more than half a millimetre goes: bare wood is pruned, a
/// fruit is thinned.
/// @throws std::invalid_argument naming a branch that breaks.
void hang_fruits(AppleTree& tree, const OrchardConfig& config,
                 const std::vector<FruitModel>& models, bool bends,
                 const BranchSettler& settle = settle_branches);

/// Turns leaves that stand in fruits or takes them off.
void clear_leaves(AppleTree& tree, const std::vector<FruitModel>& fruits,
                  const std::vector<PlantModel>& leaves);

/// Turns leaves that pass through others until they do not, and takes off those that find no place.
/// @param coarse  the leaf models in detail 0, whose crossings are sought
void part_leaves(AppleTree& tree, const std::vector<FruitModel>& fruits,
                 const std::vector<PlantModel>& leaves, const std::vector<PlantModel>& coarse);

/// Looks of the parts of a tree's and of a leaf's model, in the order of orchard_materials().
enum OrchardLook { kAppleBarkLook, kAppleShootLook, kApplePetioleLook, kAppleBladeLook };
std::vector<Material> orchard_materials(const OrchardConfig& config);

/// One leaf: petiole from the origin along +x, then the blade. @param detail  1: with teeth; 0: of
/// some 80 triangles, for trees beside it
PlantModel apple_leaf(const OrchardConfig& config, int detail, Rng rng);
/// Trunk, branches, spurs and shoots, a part each. @param detail  1: with bark; 0: coarse
PlantModel tree_wood(const AppleTree& tree, const OrchardConfig& config, int detail, Rng rng);

double height_m(const AppleTree& tree);

}  // namespace cousin
