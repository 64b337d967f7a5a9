#pragma once

#include <vector>

#include "benchmarks/report/report.h"
#include "benchmarks/score/scores.h"

namespace cousin {

/// Tables of the papers that suites fill.
std::vector<ReportTable> papers_tables(const std::vector<ScoreRow>& rows);

/// On the terminal: a line a row.
void print_scores(const std::vector<ScoreRow>& rows);
/// The papers' tables, and every number that was held against a limit or is not there.
void print_papers_tables(const std::vector<ScoreRow>& rows);

}  // namespace cousin
