#pragma once

#include <vector>

#include "benchmarks/suites/stability/stability_row.h"

namespace cousin {

/// Structure from motion that fails: no COLMAP, half of the images placed, models in pieces, a
/// board that is hardly seen, a lens that views leave open. COLMAP itself does not run.
std::vector<StabilityRow> sfm_cases();

}  // namespace cousin
