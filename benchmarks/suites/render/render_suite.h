#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "benchmarks/loop/simulate.h"
#include "benchmarks/score/scores.h"

namespace cousin {

/// The renderer's own numbers: truth pass as a share of raw ray throughput, Monte-Carlo noise
/// against the sensor's noise, seconds of the light cache and of a view; the truth pass's speed and
/// memory with millions of instanced triangles; what leaving out passes saves.
/// @throws std::invalid_argument if `sets` names a rig that is no phone.
ScoreFile render_suite(std::uint64_t seed, const std::vector<std::string>& sets, bool quick,
                       const Progress& progress = {});

}  // namespace cousin
