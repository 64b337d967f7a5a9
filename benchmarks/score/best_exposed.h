#pragma once

#include <cstdint>

#include "benchmarks/score/image_fidelity.h"
#include "sim/types/image.h"

namespace cousin {

/// `image` after the one factor on its linear light that leaves the least squares to `photograph`
/// over pixels of `mask` that are not zero (empty: all): a photograph by automatic exposure has a
/// factor that no model of the scene can know. Factors are between 1/8 and 8; where no pixel counts
/// it is 1.
FidelityPlanes best_exposed(const FidelityPlanes& image, const FidelityPlanes& photograph,
                            const Image<std::uint8_t>& mask);

}  // namespace cousin
