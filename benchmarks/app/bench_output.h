#pragma once

#include <vector>

#include "benchmarks/loop/bench_suite.h"

namespace cousin {

/// On the terminal: the suite's text and tables, and every number that was held against a limit or
/// is not there; of a suite without a text a line a row.
void print_suite(const BenchSuite& suite, const std::vector<ScoreRow>& rows);

}  // namespace cousin
