#pragma once

#include <set>
#include <vector>

#include "scenes/fruit/leaf_search.h"
#include "scenes/strawberries/plant_rows.h"
#include "scenes/strawberries/strawberries_scene.h"

namespace cousin {

/// Private to scenes/strawberries: views that see a share of a fruit.

/// The near row's leaves, which views may swing about the base of their petiole.
struct SwingingLeaves {
  TrussLeafRoom room;
  std::vector<LoneLeaf> all;
  std::set<std::size_t> swung;  ///< places of those that a view has swung: they stay
};

/// Leaves swung before a target or aside, one after the other and the last as far as it takes,
/// until `view` shows the share of it that is wanted; the scene stays as it is.
MovedLeaves swing_leaves(const Scene& scene, const SwingingLeaves& leaves, std::size_t target,
                         const TrueView& view, double reach_m, double wanted);

/// Replaces the scene's views by such of a fruit each, from which config.occlusion of it is hidden,
/// and says how far in the traits of the bed: target, visible and met with the view's number, and
/// leaves_swung.
/// @param fruits  places in scene.instances
/// @throws std::invalid_argument for one that is not met, where that is to be refused, or for no
/// room for the camera.
void add_target_views(Scene& scene, const StrawberriesSceneConfig& config,
                      const std::vector<std::size_t>& fruits, SwingingLeaves& leaves,
                      const Rng& rng);

}  // namespace cousin
