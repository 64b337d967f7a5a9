#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "benchmarks/loop/simulate.h"
#include "benchmarks/report/report.h"
#include "benchmarks/score/scores.h"
#include "benchmarks/study/shard.h"

namespace cousin {

struct CousinsSuiteConfig {
  std::uint64_t seed = 1;
  int runs = 5;                   ///< scenes at each point of each axis
  bool quick = false;             ///< one scene at 0, 0.5 and 1, small photographs: minutes
  std::vector<std::string> sets;  ///< key=value for every job
};

/// How the errors of the seeds grow with the distance from the scene that the pipeline was made on:
/// for each axis of `cousin.*` scenes at 0, 0.25, 0.5, 0.75 and 1, each axis alone. Run k has the
/// same draws at every distance of an axis, which go on along one line. Each job is one capture,
/// rendered and measured by ours, and resumes.
std::vector<ShardJob> cousins_suite_jobs(const CousinsSuiteConfig& config,
                                         const Progress& progress = {});

/// Of every axis and distance: RMSE, MAPE and bias of the five traits over the scenes, the share of
/// specimens that was found, and the jobs' own rows. Case "shape 0.25"; the twin is a point of each
/// axis.
ScoreFile pool_cousins_suite(const std::vector<ShardResult>& results,
                             const CousinsSuiteConfig& config);

/// Plots of the rows of suite "cousins": each trait's RMSE, and what was found, over the distance
/// along each axis. Of rows of other suites: none.
std::vector<LinePlot> cousins_plots(const std::vector<ScoreRow>& rows);

/// What the page says of the configuration: the twin's in full, and what each axis moves.
std::string cousins_toml(const CousinsSuiteConfig& config);

}  // namespace cousin
