// The row of `cousin bench apples`.
#include "benchmarks/loop/bench_suite.h"
#include "benchmarks/suites/apples/apples_suite.h"

namespace cousin {
namespace {

ApplesSuiteConfig apples_config_of(const SuiteRun& run) {
  return {.seed = run.seed, .quick = run.quick, .runs = run.runs, .sets = run.sets};
}

}  // namespace

BenchSuite bench_apples() {
  return {
      .name = "apples",
      .help =
          "Size, volume and mass of apples hidden in part, by ours, by the paper's chain and by "
          "four simpler ways on the same captures of a simulated D455. Boxes and masks are the "
          "true ones: there is no detector. No real tree has confirmed it.",
      .takes = {"--quick", "--runs", "--set", "--shard", "--only"},
      .jobs = [](const SuiteRun& run) { return apples_suite_jobs(apples_config_of(run)); },
      .page =
          [](const SuiteRun& run, const std::vector<ShardResult>& results) {
            ScoreFile file = scores_of_shards(results, "apples", run.seed);
            append({.scores = apples_pooled_rows(file, run.seed)}, file);
            return suite_page(std::move(file));
          },
      .plots = [](SeedsReport& report) { add_apples_plots(report); }};
}

}  // namespace cousin
