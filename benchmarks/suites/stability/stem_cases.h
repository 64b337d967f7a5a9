#pragma once

#include <vector>

#include "benchmarks/suites/stability/stability_row.h"

namespace cousin {

/// Stems as chains of hinges in MuJoCo: the longest stable step by modulus, segments, integrator
/// and damping; sag and first frequency beside theory; error of a swing beside the time that it
/// took, over step, segments and integrator; what must be refused or said.
/// @param quick  fewer combinations
std::vector<StabilityRow> stem_cases(bool quick);

}  // namespace cousin
