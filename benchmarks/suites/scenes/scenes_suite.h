#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "benchmarks/score/scores.h"

namespace cousin {

/// What the plant scenes cost and what grows in them: seconds and triangles of building each, held
/// to a second for a tray of fifty and two for rows of maize; the share of the leaf area that
/// crosses other leaves, held to 1 %; means of the traits of seedlings by day and of maize by
/// stage, with 95 % intervals over plants. Traits with a source are held to its 95 % interval
/// ("height.off_..." in its sigmas); the others are free and have no limits.
/// @param quick  fewer days, stages and repeats; the same columns
ScoreFile scenes_suite(std::uint64_t seed, bool quick,
                       const std::function<void(const std::string&, int, int)>& progress);

}  // namespace cousin
