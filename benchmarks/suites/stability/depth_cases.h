#pragma once

#include <vector>

#include "benchmarks/suites/stability/stability_row.h"

namespace cousin {

/// Multi-view stereo and the fusion of depth images where they have little to go by: worlds far
/// from their origin, one view, the same view again, surfaces without texture, black photographs,
/// wrong poses, depths that are NaN, views in another order, scenes rescaled.
std::vector<StabilityRow> depth_cases();

}  // namespace cousin
