#pragma once

#include <vector>

#include "benchmarks/suites/stability/stability_row.h"

namespace cousin {

/// Calibrations that the views do not determine, or nearly: parallel boards, few images, a narrow
/// lens, a board in a corner; units and origins; outliers; folding lenses; motions of an arm that
/// leave the hand-eye transform open. What cannot be known must be said so.
std::vector<StabilityRow> calibration_cases();

}  // namespace cousin
