#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "benchmarks/score/scores.h"
#include "benchmarks/study/shard.h"

namespace cousin {

struct ShapesSuiteConfig {
  std::uint64_t seed = 1;
  bool quick = false;
  int runs = 0;  ///< of ten specimens, of each shape; 0 = 4
  std::vector<std::string> sets;
};

/// Specimens of five shapes that nothing here was tuned on, each grown its own way
/// (mesh_variation.h), measured as seeds are: do sizes and their intervals hold on any shape?
std::vector<ShardJob> shapes_suite_jobs(const ShapesSuiteConfig& config);

/// Statistics of each shape over all runs. Held to limits for each shape: the bias of height
/// (0.05 mm), over all traits the share of 95 % intervals that hold (0.90 to 0.98) and, of each
/// length, the mean width of the intervals over the RMSE (4.7).
std::vector<ScoreRow> shapes_pooled_rows(const std::vector<SpecimenRow>& specimens,
                                         std::uint64_t seed);

}  // namespace cousin
