#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "benchmarks/app/options.h"
#include "benchmarks/loop/plan.h"
#include "benchmarks/score/scores.h"

namespace cousin {

/// Prints each of the command's --gate that does not hold, and says by the exit code if there is
/// one. @throws std::invalid_argument naming a text that is no gate.
ExitCode check_gates(const Options& options, const std::vector<ScoreRow>& rows);

/// Scene, metric, value, unit and what its status says beside ok, a line each.
void print_rows(const std::vector<ScoreRow>& rows);

/// To standard output: all of it with --json, else a table of traits, where there are some, or the
/// rows.
void print_result(const Options& options, const ScoreFile& file);

/// To standard output. Bytes that are not UTF-8, as a path may have, are shown ("\\xe9").
void print_json(const nlohmann::json& value);

/// What will run, what is left out and why: lines, or a list with --json.
void print_plan(const Options& options, const std::vector<PlanEntry>& plan);

}  // namespace cousin
