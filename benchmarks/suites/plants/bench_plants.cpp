// The row of `cousin bench plants`.
#include "benchmarks/loop/bench_suite.h"
#include "benchmarks/suites/plants/plants_suite.h"

namespace cousin {

BenchSuite bench_plants() {
  return {.name = "plants",
          .help =
              "Fruits and trusses: sizes beside the published ones, red shares, seconds to "
              "build, overlaps at rest. Verified against theory and publications only.",
          .takes = {"--quick"},
          .page = [](const SuiteRun& run, const std::vector<ShardResult>&) {
            return suite_page(plants_suite(run.seed, run.quick, run.progress));
          }};
}

}  // namespace cousin
