#pragma once

#include <vector>

#include "benchmarks/suites/stability/stability_row.h"

namespace cousin {

/// Box, hull and alpha shape on coplanar, collinear, duplicate, single and far-away points: sizes
/// are exact or zero, never NaN, and nothing throws.
std::vector<StabilityRow> geometry_cases();

}  // namespace cousin
