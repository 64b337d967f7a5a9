#pragma once

#include <vector>

#include "benchmarks/report/report.h"
#include "benchmarks/score/scores.h"

namespace cousin {

/// Tables 1 to 5 of the Seeds paper and its paired tests, of pooled rows of `bench seeds`: what it
/// published beside its two ways and ours on our captures. Lines without a number of ours are of
/// the paper alone; no tables where no model was trained.
std::vector<ReportTable> seeds_paper_tables(const std::vector<ScoreRow>& rows);

}  // namespace cousin
