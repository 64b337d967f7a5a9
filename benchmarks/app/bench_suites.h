#pragma once

#include <filesystem>
#include <vector>

#include "benchmarks/app/commands.h"
#include "benchmarks/loop/bench_suite.h"

namespace cousin {

/// All, in the order in which `cousin bench` without a name runs them.
const std::vector<BenchSuite>& bench_suites();

/// What the command line asks of a suite whose folder is `out`.
SuiteRun suite_run(const JobContext& context, const std::filesystem::path& out);

/// Measures what the folder holds no result of, writes tables and page there.
ScoreFile run_suite(const BenchSuite& suite, const JobContext& context,
                    const std::filesystem::path& out);

}  // namespace cousin
