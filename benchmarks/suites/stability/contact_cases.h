#pragma once

#include <vector>

#include "benchmarks/suites/stability/stability_row.h"

namespace cousin {

/// MuJoCo's contacts at the size of seeds: rest depth, impact depth, tunnelling, creep on a slope,
/// and the step of the settle preset against error and time. Rows "engine defaults" show what the
/// preset of sim/physics/settle.h avoids; their limits hold them to what MuJoCo 2.2.2 was measured
/// to do, so that another engine version shows.
/// @param quick  fewer steps and speeds
std::vector<StabilityRow> contact_cases(bool quick);

}  // namespace cousin
