#include "benchmarks/app/suite_plots.h"

#include "benchmarks/app/bench_suites.h"

namespace cousin {

void add_plots(SeedsReport& report) {
  report.curves = {};
  report.lines = {};
  report.tables = {};
  for (const BenchSuite& suite : bench_suites()) {
    if (suite.plots != nullptr) suite.plots(report);
  }
}

void require_plots(const SeedsReport&) {}

}  // namespace cousin
