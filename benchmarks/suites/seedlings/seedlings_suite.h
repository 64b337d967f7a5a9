#pragma once

#include <string>
#include <vector>

#include "benchmarks/score/scores.h"
#include "benchmarks/study/shard.h"
#include "benchmarks/suites/seedlings/seedlings_jobs.h"

namespace cousin {

/// Tables 2 to 4 of the Seedlings paper on rendered trays: PSNR of Gaussians and of a radiance
/// field under three lights, on views that were trained on and on others, and what missing views
/// do. Jobs of minutes.
std::vector<ShardJob> seedlings_suite_jobs(const SeedlingsSuiteConfig& config);

/// All rows of the jobs, their means over the samples, ours beside the reference after the same
/// seconds, and the published rows with their means.
ScoreFile pool_seedlings_suite(const std::vector<ShardResult>& results,
                               const SeedlingsSuiteConfig& config);

/// Holds the means among pooled rows to their limits, and adds the gaps that have one; not of a
/// quick run.
void hold_seedlings_suite(const SeedlingsSuiteConfig& config, ScoreFile& pooled);

/// What the samples' scenes have in common, and each job.
std::string seedlings_toml(const SeedlingsSuiteConfig& config);

}  // namespace cousin
