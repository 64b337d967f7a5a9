#pragma once

#include <cstdint>
#include <vector>

#include "benchmarks/study/shard.h"

namespace cousin {

/// Every sensor model against theory or the published figure, in jobs of minutes: one for each
/// depth camera, one for its speed, one for each other kind. A job's result is a ScoreFile as JSON.
/// @param quick  fewer frames, the same rows
std::vector<ShardJob> sensors_suite_jobs(std::uint64_t seed, bool quick);

}  // namespace cousin
