#pragma once

#include <cstdint>
#include <vector>

#include "benchmarks/report/report.h"
#include "benchmarks/score/scores.h"
#include "benchmarks/study/shard.h"

namespace cousin {

struct StudiesConfig {
  std::uint64_t seed = 1;
  int runs = 5;        ///< boards, cameras and photographs of each point
  bool quick = false;  ///< one run of fewer points and photographs: minutes
};

/// What a calibration is worth, and what it takes: each job photographs a board for the points
/// that share its light, finds it, calibrates in each of the points' ways and measures how far the
/// lens found is from the true one (calibration_errors.h). Run k of all points is the same camera.
std::vector<ShardJob> study_jobs(const StudiesConfig& config);

/// For each study, point and method over the runs: RMS of each error with a 95 % interval, the
/// reprojection error in three definitions, the predicted deviations, the share of runs that were
/// solved; wall_s = seconds of finding the board and solving. `rows` are the jobs' own.
std::vector<ScoreRow> study_rows(const std::vector<ScoreRow>& rows, const StudiesConfig& config);

/// Where a fresh calibration begins to beat the lens that the device reports, of rows that
/// study_rows pooled: for each drift, number of photographs and error "ERROR.crossing", in the
/// drift's unit, linear between the points of the sweep (0: from the start; none: not_solved); and
/// for the study of images the fewest photographs of the sweep that beat it.
std::vector<ScoreRow> crossing_rows(const std::vector<ScoreRow>& pooled);

/// Errors over what each study varies, of rows of study_rows.
std::vector<LinePlot> study_plots(const std::vector<ScoreRow>& rows);
/// How far causes of a wrong calibration lead astray, of rows of cause_rows.h.
std::vector<LinePlot> cause_plots(const std::vector<ScoreRow>& rows);
/// Errors of fruits' places over distance beside the published ones, of rows of fruit_positions.h.
std::vector<LinePlot> position_plots(const std::vector<ScoreRow>& rows);
/// Error over seconds, of the same.
std::vector<ErrorTimeCurve> study_times(const std::vector<ScoreRow>& rows);

}  // namespace cousin
