#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scenes/seeds/seed_shape.h"

namespace cousin {

/// What a seed of the species shows from outside; a part's number is its place here.
const std::vector<std::string>& seed_part_names(Species species);

/// The part of each triangle, by where the middle of its corners lies on the seed. A border stands
/// about where the displacement or the colour that makes a part fades to half.
std::vector<std::uint16_t> seed_parts(const SeedShape& shape, Species species);

}  // namespace cousin
