#pragma once

#include "scenes/apples/apples_scene.h"

namespace cousin {

/// Private to scenes/apples.

/// The fruits of a tree as instances with calyx and stalk: "PREFIXapple NNN".
struct FruitModels {
  int first_model = 0;     ///< of the scene: flesh, calyx, stalk of each fruit model in turn
  int first_material = 0;  ///< the same
};
FruitModels add_fruit_models(Scene& scene, const std::vector<FruitModel>& fruits);
/// @return places of the flesh in scene.instances
std::vector<std::size_t> add_fruits(Scene& scene, const std::string& prefix, const AppleTree& tree,
                                    const Pose& world_from_tree, const AppleCultivar& cultivar,
                                    const std::vector<FruitModel>& fruits,
                                    const FruitModels& models);

/// The other trees: few, each many times. Those nearest in the row bear specimens, the rest coarse
/// fruits.
void add_neighbours(Scene& scene, const ApplesSceneConfig& config,
                    const std::vector<FruitModel>& fruits, const FruitModels& models,
                    int first_material, const Rng& rng);

}  // namespace cousin
