#pragma once

#include <string>
#include <vector>

#include "scenes/seeds/seeds_scene.h"

namespace cousin {

/// Length, width, height of the minimum-volume box (m), area (m2), volume (m3) and mass (kg).
std::vector<TrueTrait> measure_traits(const Mesh& mesh, double mass_kg);

/// A specimen of any closed mesh in metres, moved to its centroid, uncoloured.
/// @throws std::runtime_error saying why the mesh is not closed.
SeedModel make_specimen(const std::string& name, const Mesh& mesh, double density_kg_m3);

}  // namespace cousin
