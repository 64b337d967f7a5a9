#pragma once

#include <vector>

#include "benchmarks/suites/stability/stability_row.h"

namespace cousin {

/// Light and truth at their limits: radiance at scales 1e-4..1e4 and distances to 1e5 m against
/// the same scene at scale 1, sheets that nearly touch, closed boxes that lose no light, cameras on
/// and in surfaces, lights inside bodies, overlapping leaves, pictures of one texel, lights and
/// materials that must be refused by name, files that cannot be read.
/// @param quick  fewer samples, with wider limits.
std::vector<StabilityRow> path_cases(bool quick);

}  // namespace cousin
