#pragma once

#include "benchmarks/loop/seeds_report.h"

namespace cousin {

/// Of the page of `bench real`, whose pictures only that command makes.
inline constexpr const char* kRealTitle = "Cousin: bench real";

/// Plots and tables that suites make of their rows: on the page at once, and again from the tables
/// alone.
/// Where the suites are not built there are none.
void add_plots(SeedsReport& report);

/// @throws std::invalid_argument for a suite's page where the suites are not built, saying how to
/// build them
void require_plots(const SeedsReport& report);

}  // namespace cousin
