#pragma once

#include <vector>

#include "scenes/apples/apples_scene.h"

namespace cousin {

/// Private to scenes/apples.

/// Where the parts of the scene's tree are among its instances.
struct TreeInstances {
  std::size_t wood = 0;
  std::vector<std::size_t> fruits;  ///< the flesh of each; its calyx and stalk follow
  std::size_t first_leaf = 0;
};

/// What in a tree moves as one: a section of a branch or spur.
struct WoodPiece {
  BranchPlace place;
  ObjectModel model;                ///< in the tree's frame, with the parts that it has
  std::vector<int> part_materials;  ///< of these
};
/// The wood in pieces, the trunk's first. Where branches bend, pieces part or overlap by their
/// radius times a hinge's angle: hundredths of a millimetre in a fresh wind.
/// @param part_materials  of the wood's parts, which are its axes in order
std::vector<WoodPiece> cut_wood(const AppleTree& tree, const ObjectModel& wood,
                                const std::vector<int>& part_materials);

/// Gives branches with all that they carry their motion about the times of the scene's views, from
/// rest on: in gusts that all feel, and one under a hand. Each section's wood becomes an instance
/// of its own; leaves and fruits move with the section that carries them. Still air without a hand
/// changes nothing.
/// @throws std::invalid_argument for a hand on a branch or view that is not there, a tree that does
/// not hang, and a branch that breaks; std::runtime_error if the engine cannot go on.
void sway_tree(Scene& scene, const ApplesSceneConfig& config, const GrownTree& grown,
               const TreeInstances& where, const Rng& rng);

}  // namespace cousin
