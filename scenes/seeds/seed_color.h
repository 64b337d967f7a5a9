#pragma once

#include <vector>

#include "scenes/seeds/seed_shape.h"
#include "sim/types/image.h"

namespace cousin {

/// Linear diffuse reflectance of each vertex: the species' coloured regions under mottling made in
/// 3D.
std::vector<Rgbf> color_seed(const CultivarConfig& config, const SeedShape& shape, Rng rng);

}  // namespace cousin
