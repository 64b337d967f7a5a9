#pragma once

#include <vector>

#include "benchmarks/suites/stability/stability_row.h"

namespace cousin {

/// Gaussian splatting where rasterisers break: scales from 1e-9 to 1e3, quaternions of no length,
/// centres at and behind the camera, scenes rescaled and far from zero, Gaussians in another order;
/// the float kernels beside the double reference.
std::vector<StabilityRow> splat_cases();

}  // namespace cousin
