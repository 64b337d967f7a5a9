#include "benchmarks/shards/shard_scores.h"

#include <utility>

namespace cousin {

ScoreFile scores_of_shards(const std::vector<ShardResult>& results, const std::string& suite,
                           std::uint64_t seed) {
  ScoreFile all;
  for (const ShardResult& result : results) {
    if (!result.text.empty()) {
      append(scores_from_json(result.text, result.name), all);
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
  return all;
}

}  // namespace cousin
