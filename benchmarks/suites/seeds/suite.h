#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "benchmarks/loop/simulate.h"
#include "benchmarks/score/scores.h"
#include "benchmarks/study/shard.h"

namespace cousin {

struct SeedsSuiteConfig {
  std::uint64_t seed = 1;
  int runs = 5;                    ///< of each cultivar at 60 views
  bool quick = false;              ///< one cultivar a species, few views, small images: minutes
  bool attribution = false;        ///< truth in each seam for run 0 of each cultivar
  std::vector<std::string> sets;   ///< key=value for every job
  std::filesystem::path captures;  ///< keeps what is rendered for later runs; empty = nowhere
  /// Where jobs leave what the page shows of them, as scenes of their names; empty = nowhere.
  std::filesystem::path report;
  /// Trainings that were stopped go on from here, in a folder a job; empty: none do.
  std::filesystem::path unfinished;
  std::filesystem::path lpips;  ///< network that images of Gaussians are scored by; empty: none
};

/// The Seeds experiment: for each cultivar runs of ten seeds at the paper's imaging (1920 x 1080,
/// 60 views; 270 for one run), on the same captures the paper's measuring steps and ours; the
/// error-against-time curves over views and image size; a run at the spread of sizes that the
/// paper's R^2 implies; the 22 mm sphere; models trained on 60 views of 1280 x 720, of one cultivar
/// also by poses of COLMAP, whose cases end with ", poses sfm" or ", poses adjusted". Each job is
/// one capture, minutes long, and resumes.
std::vector<ShardJob> seeds_suite_jobs(const SeedsSuiteConfig& config,
                                       const Progress& progress = {});

/// Rows of all finished jobs with the statistics over runs. Jobs that failed become rows with
/// status error.
ScoreFile pool_seeds_suite(const std::vector<ShardResult>& results, const SeedsSuiteConfig& config);
/// Holds pooled rows to their limits: of the whole experiment, not of a quick one or with `sets`.
void hold_seeds_suite(const SeedsSuiteConfig& config, ScoreFile& pooled);

/// What the page says of the suite's configuration: the first job's in full as TOML, and how each
/// job differs from it.
std::string suite_toml(const SeedsSuiteConfig& config);

}  // namespace cousin
