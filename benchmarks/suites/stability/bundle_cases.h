#pragma once

#include <vector>

#include "benchmarks/suites/stability/stability_row.h"

namespace cousin {

/// Bundle adjustment and triangulation: units, far origins, gauges, parallel views, tiny parallax.
std::vector<StabilityRow> bundle_cases(bool quick);

}  // namespace cousin
