#pragma once

#include <span>
#include <string>

#include "benchmarks/app/options.h"
#include "benchmarks/app/progress.h"

namespace cousin {

/// What every verb gets.
struct JobContext {
  const Options& options;
  std::string command_line;  ///< as given, for the report
  ProgressPrinter& progress;
};

/// One function a verb. They throw std::invalid_argument for wrong usage or configuration,
/// StageError for a failed stage, other std::exceptions for bad input.
ExitCode command_scenes(const JobContext& context);
ExitCode command_rigs(const JobContext& context);
ExitCode command_methods(const JobContext& context);
ExitCode command_doctor(const JobContext& context);
ExitCode command_render(const JobContext& context);
ExitCode command_perceive(const JobContext& context);
ExitCode command_score(const JobContext& context);
ExitCode command_score_detections(const JobContext& context);  ///< score DATASET FILE
ExitCode command_run(const JobContext& context);
ExitCode command_board(const JobContext& context);
ExitCode command_calibrate(const JobContext& context);
ExitCode command_fit_sensor(const JobContext& context);
ExitCode command_bench(const JobContext& context);
ExitCode command_import(const JobContext& context);
ExitCode command_export(const JobContext& context);
ExitCode command_ledger(const JobContext& context);
ExitCode command_measure(const JobContext& context);
ExitCode command_verify(const JobContext& context);
ExitCode command_report(const JobContext& context);

/// Whose fault it is if memory is short: of what the files ask for, or of the work that is asked
/// for.
enum class Reads { input, nothing };

/// A verb that a module holds.
struct Verb {
  const char* name;
  ExitCode (*run)(const JobContext& context);
  Reads reads = Reads::nothing;
};
/// All of this module: `verbs_of_jobs.cpp` or another, as CMake picks for each.
std::span<const Verb> module_verbs();

}  // namespace cousin
