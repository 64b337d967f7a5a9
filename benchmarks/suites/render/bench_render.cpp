// The row of `cousin bench render`.
#include "benchmarks/loop/bench_suite.h"
#include "benchmarks/loop/seeds_run.h"
#include "benchmarks/suites/render/render_suite.h"

namespace cousin {

BenchSuite bench_render() {
  return {.name = "render",
          .help =
              "The renderer beside Embree alone, its noise beside the sensor's, its corners "
              "beside where they project.",
          .takes = {"--quick", "--set"},
          .page = [](const SuiteRun& run, const std::vector<ShardResult>&) {
            SuitePage page = suite_page(render_suite(run.seed, run.sets, run.quick, run.progress));
            page.report.config_toml = resolved_toml(seeds_run_config(run.sets));
            return page;
          }};
}

}  // namespace cousin
