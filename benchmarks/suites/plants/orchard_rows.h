#pragma once

#include <cstdint>
#include <vector>

#include "benchmarks/score/scores.h"

namespace cousin {

/// The apple scene: seconds of building a tree in full leaf (at most two) and of hanging its fruits
/// (at most ten), overlaps at rest, leaves that cross, and the visible fraction asked for beside
/// the one that the truth pass sees with the rig's own camera, over several fruits.
/// @param quick  fewer fractions and fruits
std::vector<ScoreRow> orchard_rows(std::uint64_t seed, bool quick);

}  // namespace cousin
