#pragma once

#include <string>
#include <vector>

#include "benchmarks/loop/run_config.h"
#include "benchmarks/score/image_scores.h"
#include "benchmarks/score/scores.h"
#include "benchmarks/suites/sfm/sfm_suite.h"
#include "perception/sfm/sfm_poses.h"

namespace cousin {

/// A row of the suite without its number.
ScoreRow sfm_row(const SfmSuiteConfig& config, const std::string& scene, const std::string& method);

/// `row` with a number, and its limit if there is one: metric "NAME (at most 0.333)".
ScoreRow numbered(ScoreRow row, const std::string& metric, double value, const std::string& unit,
                  std::int64_t n);
ScoreRow at_most(ScoreRow row, const std::string& metric, double value, const std::string& unit,
                 std::int64_t n, double limit);

/// views.placed, camera.centre_rms (m and share of the distance), camera.rotation_rms.
std::vector<ScoreRow> pose_rows(const ScoreRow& row, const PoseScore& score);

/// A row that says why there are no numbers.
ScoreRow missing_row(ScoreRow row, const std::string& why, ScoreStatus status);
/// The same of an end without poses.
/// @throws std::runtime_error where the machine is to blame (a program that failed, or was out of
///         time): a row would be kept, another try may end well
ScoreRow unsolved_row(ScoreRow row, const std::string& why, SfmStatus status);

/// The capture of `seeds_sfm_rows`.
RunConfig seeds_sfm_scene(const SfmSuiteConfig& config);

/// The jobs' rows.
std::vector<ScoreRow> neutral_rows(const SfmSuiteConfig& config);
std::vector<ScoreRow> seeds_sfm_rows(const SfmSuiteConfig& config, const Progress& progress);

}  // namespace cousin
