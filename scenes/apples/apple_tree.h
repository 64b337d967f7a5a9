#pragma once

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
};

/// How a tree came to hang.
struct TreeRest {
  bool is_bent = false;  ///< false: built without MuJoCo; branches keep their unloaded shape
  int branches = 0;      ///< that bear fruits
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
  TreeRest rest;
};

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

/// Bends the branches under their fruits to rest, each by itself, in parallel; without `bends` or
/// MuJoCo they stay. Then what overlaps by more than half a millimetre goes: bare wood is pruned, a
/// fruit is thinned.
/// @throws std::invalid_argument naming a branch that breaks.
void hang_fruits(AppleTree& tree, const OrchardConfig& config,
                 const std::vector<FruitModel>& models, bool bends);

/// Turns leaves that stand in fruits or takes them off.
void clear_leaves(AppleTree& tree, const std::vector<FruitModel>& fruits,
                  const std::vector<PlantModel>& leaves);

/// Looks of the parts of a tree's and of a leaf's model, in the order of orchard_materials().
enum OrchardLook { kAppleBarkLook, kAppleShootLook, kApplePetioleLook, kAppleBladeLook };
std::vector<Material> orchard_materials(const OrchardConfig& config);

/// One leaf: petiole from the origin along +x, then the blade. @param detail  1: with teeth; 0: of
/// 16 triangles, for trees far away
PlantModel apple_leaf(const OrchardConfig& config, int detail, Rng rng);
/// Trunk, branches, spurs and shoots, a part each. @param detail  1: with bark; 0: coarse
PlantModel tree_wood(const AppleTree& tree, const OrchardConfig& config, int detail, Rng rng);

double height_m(const AppleTree& tree);

}  // namespace cousin
