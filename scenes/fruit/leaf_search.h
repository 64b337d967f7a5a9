#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "sim/geometry/share_search.h"
#include "sim/render/visible_share.h"

namespace cousin {

/// A leaf that may be moved to hide a fruit or to show it.
struct MovableLeaf {
  std::size_t place = 0;                      ///< into scene.instances
  std::function<Pose(double share)> pose_at;  ///< world_from_object, 0 = at rest, 1 = all the way
  std::function<bool(double share)> is_free;  ///< whether it meets nothing there
};

/// Leaves to move, and the share that a target then shows.
struct MovedLeaves {
  ShareFound found;
  std::vector<MovedInstance> moved;
};

/// The leaves one after the other, in their order, each all the way and the last as far as it
/// takes, until `view` shows the share of the target that is wanted; the scene stays as it is.
/// @param target  place in scene.instances.  @param view  as view_about gives it
/// @param reach_m  as VisibleShare takes it
MovedLeaves move_leaves(const Scene& scene, const std::vector<MovableLeaf>& leaves,
                        std::size_t target, const TrueView& view, double reach_m, double wanted);

}  // namespace cousin
