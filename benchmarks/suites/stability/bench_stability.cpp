// The row of `cousin bench stability`.
#include "benchmarks/loop/bench_suite.h"
#include "benchmarks/suites/stability/suite.h"

namespace cousin {

BenchSuite bench_stability() {
  return {.name = "stability",
          .help = "Stiff and extreme cases, each held to theory or to a measured value.",
          .takes = {"--quick"},
          .page = [](const SuiteRun& run, const std::vector<ShardResult>&) {
            return suite_page(stability_suite(run.quick, run.progress));
          }};
}

}  // namespace cousin
