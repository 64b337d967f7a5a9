#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "benchmarks/score/scores.h"
#include "benchmarks/tools/calibrate/calibration_run.h"

namespace cousin {

/// calibration.json: status, board, cameras with parameters and deviations, their places, each
/// image's points and residual, warnings, the next view. Numbers read back equal; NaN is null.
std::string calibration_json(const CalibrationRun& run);

/// The same for a person, in pixels, millimetres and degrees.
std::string calibration_table(const CalibrationRun& run);

/// One row a parameter, with its 95 % interval.
std::vector<ScoreRow> calibration_rows(const CalibrationRun& run);

/// Files and folders that a calibration writes beside its tables and page.
std::vector<std::string> calibration_names();

/// opencv/, ros/, kalibr/, mrcal/ and colmap/ below `folder`, but none that has no such lens: the
/// returned lines say which and why. With problems nothing is written. Nothing is removed.
std::vector<std::string> write_calibration_files(const std::filesystem::path& folder,
                                                 const CalibrationRun& run);

/// report.html: verdict, coverage, residuals, uncertainty, what to shoot next.
void write_calibration_report(const std::filesystem::path& file, const CalibrationRun& run,
                              const ScoreFile& scores, const std::string& command_line);

}  // namespace cousin
