#pragma once

#include <cstdint>
#include <vector>

#include "benchmarks/metrics/scores.h"
#include "benchmarks/report/report.h"
#include "benchmarks/shards/shard.h"

namespace cousin {

struct StudiesConfig {
  std::uint64_t seed = 1;
  int runs = 5;        ///< boards, cameras and photographs of each point
  bool quick = false;  ///< one run of fewer points and photographs: minutes
};

/// What a calibration is worth, and what it takes: each job photographs a board for one point of
/// one study, finds it, calibrates in each of the study's ways and measures how far the lens found
/// is from the true one (calibration_errors.h). Run k of all points of a study is the same camera.
std::vector<ShardJob> study_jobs(const StudiesConfig& config);

/// For each study, point and method over the runs: RMS of each error with a 95 % interval, the
/// reprojection error in three definitions, the predicted deviations, the share of runs that were
/// solved; wall_s = seconds of finding the board and solving. `rows` are the jobs' own.
std::vector<ScoreRow> study_rows(const std::vector<ScoreRow>& rows, const StudiesConfig& config);

/// Errors over what each study varies, of rows of study_rows.
std::vector<LinePlot> study_plots(const std::vector<ScoreRow>& rows);
/// Error over seconds, of the same.
std::vector<ErrorTimeCurve> study_times(const std::vector<ScoreRow>& rows);

}  // namespace cousin
