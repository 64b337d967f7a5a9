#pragma once

#include <vector>

#include "scenes/apples/apples_scene.h"
#include "scenes/apples/leaf_turns.h"

namespace cousin {

/// Private to scenes/apples. Appends the scene's views, each of a fruit of its own as far as there
/// are such in sight, and what is known of them to the traits of `tree`.
/// @param apples  places in scene.instances of the tree's fruits
/// @param tree  place of the tree's wood
void add_apple_views(Scene& scene, const ApplesSceneConfig& config,
                     const std::vector<std::size_t>& apples, TurnableLeaves& leaves,
                     std::size_t tree, const Rng& rng);

/// Appends views of the whole tree, from the alley of -y and the other in turns, each a little
/// aside of the one before and higher or lower.
void add_tree_views(Scene& scene, const ApplesSceneConfig& config, const Rng& rng);

}  // namespace cousin
