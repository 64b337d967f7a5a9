#pragma once

#include <functional>
#include <set>
#include <vector>

#include "scenes/apples/apples_scene.h"
#include "scenes/apples/placed_fruit.h"
#include "sim/geometry/share_search.h"
#include "sim/render/visible_share.h"

namespace cousin {

/// Private to scenes/apples.

/// The leaves of the scene's tree, which views may turn about the base of their petiole.
struct TurnableLeaves {
  const GrownTree& grown;
  std::size_t first = 0;  ///< place in scene.instances of the tree's first leaf
  LeafRoom room;
  std::set<std::size_t> turned;  ///< places of those that a view has turned: they stay
};

/// Turns leaves near a target before it or aside, one after the other and the last as far as it
/// takes, until `view` shows the share of it that is wanted. The scene's leaves are turned only if
/// that brings the share nearer.
/// @param view  as view_about gives it
/// @return share and whether it is met
ShareFound turn_leaves(Scene& scene, TurnableLeaves& leaves, std::size_t target,
                       const TrueView& view, double reach_m, double wanted);

}  // namespace cousin
