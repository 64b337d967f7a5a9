#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "perception/fruit/fruit_lump.h"
#include "sim/config/fields.h"

namespace cousin {

/// How many fruits a tree bears and how heavy they are together, from those that are seen.
struct TreeYieldConfig {
  /// Place of the tree in its row, about the world's z axis: what hangs between the trunk and half
  /// the way to the next, along x, and to the alleys' middle, along y, counts.
  double along_m = 1.1, across_m = 3.4;
  double located_m = 0.1;     ///< largest sigma of a fruit's place that is known
  double common_share = 0.4;  ///< of a fruit's variance, the same in all views of it
  double count_sigma = 0.02;  ///< of the count: boxes joined wrongly
  double mass_sigma = 0.02;   ///< of what all masses are off, over them
};
Fields fields(TreeYieldConfig& config);
/// @throws std::invalid_argument naming key, value and limit
void validate(const TreeYieldConfig& config);

/// Whether a point of the world is in the tree's place.
bool is_in_place(const Eigen::Vector3d& point_in_world_m, const TreeYieldConfig& config);

/// One number of one fruit as its views measure it: the mean by their variances, whose sigma is at
/// least that of what all views share, and grows where they disagree. NaN without views.
FruitMeasure fused(std::span<const FruitMeasure> views, double common_share);

/// How often a fruit was seen, and its mass, NaN if no view measures it.
struct SeenFruit {
  int views = 0;
  FruitMeasure mass_kg;
  /// Whether its place is known. A box that none can be joined to for want of a place is no sign of
  /// fruits that no view shows.
  bool is_located = true;
};
struct TreeYield {
  int seen = 0;
  FruitMeasure count;     ///< with those that no view shows
  FruitMeasure yield_kg;  ///< NaN where no fruit has a mass
};

/// Fruits that no view shows are counted by how many are seen once and twice [Chao, Biometrics
/// 43(4), 783, 1987, for unequal chances to be seen; the bias-corrected form and its variance].
/// They, and those that no view measures, have the mean mass of the others.
/// @param views  that show the tree
TreeYield yield_of(std::span<const SeenFruit> fruits, int views,
                   const TreeYieldConfig& config = {});

}  // namespace cousin
