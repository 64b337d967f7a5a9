#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "benchmarks/metrics/scores.h"

namespace cousin {

/// What the plant scenes cost and what grows in them: seconds and triangles of building each, held
/// to a second for a tray of fifty and two for rows of maize; means of the traits of seedlings by
/// day and of maize by stage, with 95 % intervals over plants. Their numbers are free, so that the
/// traits have no limits to be held to.
/// @param quick  fewer days, stages and repeats; the same columns
ScoreFile scenes_suite(std::uint64_t seed, bool quick,
                       const std::function<void(const std::string&, int, int)>& progress);

}  // namespace cousin
