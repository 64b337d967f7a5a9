#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "benchmarks/score/equal_time.h"
#include "benchmarks/score/scores.h"
#include "benchmarks/study/shard.h"

namespace cousin {

/// Rows and specimens of all finished jobs in their order, each read from a job's text
/// (scores.json); a job that failed gives a row of `suite` whose case is the job's name, whose
/// metric says why and whose status is error. Of the header it says on which machines jobs were
/// run, "unknown" among them where a job does not say: seconds of several do not compare.
/// @throws std::runtime_error naming a job whose text is not scores.json
ScoreFile scores_of_shards(const std::vector<ShardResult>& results, const std::string& suite,
                           std::uint64_t seed);

/// The machine that each training's rows were made on, as far as jobs say it.
TrainingMachines machines_of_shards(const std::vector<ShardResult>& results);

}  // namespace cousin
