#pragma once

#include <cstdint>

#include "benchmarks/loop/simulate.h"
#include "benchmarks/score/scores.h"

namespace cousin {

/// What calibrations are worth, on corners computed with known noise: three solvers on the same
/// corners, corners without noise, coverage of predicted intervals, seconds, rigs. Limits are in
/// the metrics' names.
/// @param quick  fewer calibrations behind each coverage
ScoreFile calibration_suite(std::uint64_t seed, bool quick, const Progress& progress = {});

}  // namespace cousin
