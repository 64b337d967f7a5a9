#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "benchmarks/loop/simulate.h"
#include "benchmarks/score/scores.h"
#include "benchmarks/study/shard.h"

namespace cousin {

struct SfmSuiteConfig {
  std::uint64_t seed = 1;
  bool quick = false;             ///< fewer views of the rendered capture
  std::filesystem::path folder;   ///< COLMAP's files are kept below; a stopped run goes on there
  std::filesystem::path neutral;  ///< 48 views with exact poses (transforms.json)
  std::string program = "colmap";
  int threads = 2;  ///< of COLMAP
};

/// Poses by COLMAP before and after our adjustment:
/// - on the neutral views, pairs by order against all pairs: seconds, views placed, pose errors;
/// - on a rendered capture of seeds: the Seeds paper's way against ours, in metres; the lens from
///   the plants alone against the true one.
/// Each job is minutes; its text is scores.json. Where COLMAP or the neutral views are absent, rows
/// are not_built and say so.
std::vector<ShardJob> sfm_suite_jobs(const SfmSuiteConfig& config, const Progress& progress = {});

}  // namespace cousin
