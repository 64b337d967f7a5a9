#pragma once

#include <cstdint>
#include <vector>

#include "benchmarks/score/scores.h"

namespace cousin {

/// 26,000 Gaussians at 400 x 300: core time of a blended (pixel, Gaussian) pair forward and
/// backward, for each instruction set there is, and wall time of a whole training step.
std::vector<ScoreRow> splat_kernel_rows(std::uint64_t seed);

}  // namespace cousin
