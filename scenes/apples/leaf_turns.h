#pragma once

#include <functional>
#include <set>
#include <vector>

#include "scenes/apples/apples_scene.h"
#include "scenes/apples/placed_fruit.h"
#include "scenes/fruit/leaf_search.h"

namespace cousin {

/// Private to scenes/apples.

/// The leaves of the scene's tree, which views may turn about the base of their petiole.
struct TurnableLeaves {
  const GrownTree& grown;
  std::size_t first = 0;  ///< place in scene.instances of the tree's first leaf
  LeafRoom room;
  std::set<std::size_t> turned;  ///< places of those that a view has turned: they stay
};

/// Leaves near a target turned before it or aside, one after the other and the last as far as it
/// takes, until `view` shows the share of it that is wanted; the scene stays as it is.
/// @param view  as view_about gives it
MovedLeaves turn_leaves(const Scene& scene, const TurnableLeaves& leaves, std::size_t target,
                        const TrueView& view, double reach_m, double wanted);

}  // namespace cousin
