#pragma once

#include <vector>

#include "benchmarks/suites/stability/stability_row.h"

namespace cousin {

/// Lenses that fold, see behind themselves or are bent to just before folding; light from none to
/// far beyond saturation; numbers that are no light.
std::vector<StabilityRow> lens_cases();

}  // namespace cousin
