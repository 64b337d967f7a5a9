#pragma once

#include "scenes/apples/apples_scene.h"

namespace cousin {

/// A tree of a few branches alone on its ground: a tenth of a second.
inline ApplesSceneConfig small_orchard() {
  ApplesSceneConfig config;
  config.fruits = 12;
  config.trees = config.rows = 1;
  config.views = 3;
  config.orchard.branch.count = 7;
  config.orchard.branch.last_share = 0.6;
  config.orchard.fruit.variants = 3;
  config.orchard.fruit.grid = 14;
  config.orchard.leaf.variants = 4;
  config.orchard.leaf.teeth = 0;
  config.orchard.ground.blades = 4;
  config.orchard.ground.reach_m = 0.5;
  return config;
}

}  // namespace cousin
