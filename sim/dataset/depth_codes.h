#pragma once

#include <cstdint>

#include "sim/types/image.h"

namespace cousin {

/// Private to sim/dataset: depth of floats as 16-bit numbers, 0 = none.

/// Largest depth that has a code: 65535 steps of a metre.
inline constexpr double kMostCodedDepth_m = 65535;

/// The smallest of 0.1, 1, 10, 100 and 1000 mm in steps of which a depth of at most
/// kMostCodedDepth_m has a code.
double depth_step_mm(double most_m);

/// Each depth as its nearest step, from 1 on; NaN is 0.
/// @param depth_m  in [0, 65535 steps].
Image<std::uint16_t> depth_codes(const Image<float>& depth_m, double step_mm);

}  // namespace cousin
