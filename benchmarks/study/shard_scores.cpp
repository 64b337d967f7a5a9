#include "benchmarks/study/shard_scores.h"

#include <set>
#include <string>
#include <utility>

namespace cousin {

ScoreFile scores_of_shards(const std::vector<ShardResult>& results, const std::string& suite,
                           std::uint64_t seed) {
  ScoreFile all;
  std::set<std::string> machines;
  for (const ShardResult& result : results) {
    if (!result.text.empty()) {
      const ScoreFile part = scores_from_json(result.text, result.name);
      machines.insert(part.header.machine.empty() ? "unknown" : part.header.machine);
      append(part, all);
    } else if (!result.error.empty()) {
      ScoreRow row;
      row.suite = suite;
      row.case_name = result.name;
      row.metric = result.error;
      row.seed = seed;
      row.status = ScoreStatus::error;
      all.scores.push_back(std::move(row));
    }
  }
  for (const std::string& machine : machines)
    all.header.machine += (all.header.machine.empty() ? "" : " and ") + machine;
  return all;
}

TrainingMachines machines_of_shards(const std::vector<ShardResult>& results) {
  TrainingMachines machines;
  for (const ShardResult& result : results) {
    if (result.text.empty()) continue;
    const ScoreFile part = scores_from_json(result.text, result.name);
    for (const ScoreRow& row : part.scores) machines[training_of(row)] = part.header.machine;
  }
  return machines;
}

}  // namespace cousin
