#pragma once

#include <vector>

#include "scenes/apples/orchard.h"
#include "sim/plant/plant.h"
#include "sim/truth/scene.h"
#include "sim/types/rng.h"

namespace cousin {

/// Private to scenes/apples.

/// Adds an instance of a model that is in the scene; its id is its place.
Instance& add_instance(Scene& scene, const std::string& name, const std::string& category,
                       int model, int material, const Pose& world_from_object);

/// Soil, sward in the alleys, fallen leaves on the bare strips, wires and posts along the rows,
/// which run along x; the tree at the origin.
/// @param leaf_models  models of the scene to lie on the strip; `leaf_parts` their materials
void add_orchard_ground(Scene& scene, const OrchardConfig& config,
                        const std::vector<int>& leaf_models, const std::vector<int>& leaf_parts,
                        Rng rng);

}  // namespace cousin
