#pragma once

#include <cstdint>

#include "benchmarks/metrics/scores.h"
#include "benchmarks/seeds/simulate.h"

namespace cousin {

/// Every sensor model against theory or the published figure. A part that fails is an error row;
/// the others go on.
/// @param quick  fewer frames, the same rows
ScoreFile sensors_suite(std::uint64_t seed, bool quick, const Progress& progress = {});

}  // namespace cousin
