#pragma once

#include <cstdint>
#include <vector>

#include "benchmarks/score/scores.h"

namespace cousin {

/// Time of flight and structured light against theory and the published laws: spread of depth over
/// distance, light and incidence, wiggling, multipath in a corner, edges, speed.
std::vector<ScoreRow> ranging_rows(std::uint64_t seed, bool quick);

}  // namespace cousin
