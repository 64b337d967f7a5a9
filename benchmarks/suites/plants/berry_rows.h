#pragma once

#include <cstdint>
#include <vector>

#include "benchmarks/score/scores.h"

namespace cousin {

/// Stretches of strawberries: shapes and sizes drawn beside published ones, the visible fraction
/// asked for beside the one that the truth pass sees with the rig's own camera, over several
/// fruits, and trusses in the wind: status, farthest way, seconds.
/// @param quick  fewer fractions and fruits
std::vector<ScoreRow> berry_rows(std::uint64_t seed, bool quick);

}  // namespace cousin
