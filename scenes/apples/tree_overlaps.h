#pragma once

#include <vector>

#include "scenes/apples/apple_tree.h"

namespace cousin {

/// Private to scenes/apples. Prunes bare wood and thins fruits that overlap by more than half a
/// millimetre, by the fruits' hulls; leaves the deepest overlap that is left in tree.rest.
void part_overlaps(AppleTree& tree, const std::vector<FruitModel>& models);

}  // namespace cousin
