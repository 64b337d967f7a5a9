#pragma once

#include <vector>

#include "benchmarks/suites/stability/stability_row.h"

namespace cousin {

/// Radiance fields trained on photographs that teach little, nothing or wrong things, from cameras
/// that suggest no volume, and of scenes in other units and far from the origin.
/// @param quick  half as many steps
std::vector<StabilityRow> ngp_cases(bool quick);

}  // namespace cousin
