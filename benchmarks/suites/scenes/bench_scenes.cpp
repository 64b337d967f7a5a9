// The row of `cousin bench scenes`.
#include "benchmarks/loop/bench_suite.h"
#include "benchmarks/suites/scenes/scenes_suite.h"

namespace cousin {

BenchSuite bench_scenes() {
  return {.name = "scenes",
          .help =
              "What plant scenes cost and what grows in them. Their sizes are free: the traits "
              "are printed, not held to a population.",
          .takes = {"--quick"},
          .page = [](const SuiteRun& run, const std::vector<ShardResult>&) {
            return suite_page(scenes_suite(run.seed, run.quick, run.progress));
          }};
}

}  // namespace cousin
