#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "benchmarks/loop/bench_suite.h"
#include "benchmarks/score/scores.h"
#include "benchmarks/study/shard.h"

namespace cousin {

struct ApplesSuiteConfig {
  std::uint64_t seed = 1;
  bool quick = false;  ///< one run, and the sensor's law in place of matched images
  int runs = 0;        ///< trees of each occlusion; 0 = 3
  std::vector<std::string> sets;
};

/// Trees of apples before a D455 at 0.35 to 0.75 m of a target that is hidden as far as asked for,
/// measured by all methods of the pipeline apples:
///   hidden_P_runN   of the Fuji shape, P percent of the target hidden
///   family_P_runN   of another shape family; the strength of the second prior was set with it
///                   in view
///   level_runN      all views level, nothing of the target hidden: fruits are seen from one side
///   camera_NAME_P_runN  the same trees by other cameras
///   near_runN       0.1 to 0.3 m, the paper's range that lies below the sensor's least distance
/// Every box of a view counts, not the target's alone.
std::vector<ShardJob> apples_suite_jobs(const ApplesSuiteConfig& config);

/// fruit_pooled_rows with what the project aims at as limits; of the paper's chain its own figures.
std::vector<ScoreRow> apples_pooled_rows(const ScoreFile& jobs, std::uint64_t seed);

/// Errors of what is reported first, and what each camera comes to.
void add_apples_plots(SeedsReport& report);

}  // namespace cousin
