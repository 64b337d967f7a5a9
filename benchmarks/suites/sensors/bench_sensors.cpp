// The row of `cousin bench sensors`.
#include "benchmarks/loop/bench_suite.h"
#include "benchmarks/suites/sensors/sensors_page.h"
#include "benchmarks/suites/sensors/sensors_suite.h"

namespace cousin {

BenchSuite bench_sensors() {
  return {
      .name = "sensors",
      .help =
          "Every sensor model against theory or the published figure. Verified against "
          "theory only: no real device has been compared with the models.",
      .takes = {"--quick", "--shard", "--only"},
      .jobs = [](const SuiteRun& run) { return sensors_suite_jobs(run.seed, run.quick); },
      .page =
          [](const SuiteRun& run, const std::vector<ShardResult>& results) {
            SuitePage page = suite_page(scores_of_shards(results, "sensors", run.seed));
            keep_scene(page.report, sensors_pictures(run.seed), run.out);
            return page;
          },
      .plots =
          [](SeedsReport& report) { add_all(sensors_plots(report.scores.scores), report.lines); }};
}

}  // namespace cousin
