// The row of `cousin bench strawberries`.
#include "benchmarks/suites/strawberries/strawberries_suite.h"

namespace cousin {
namespace {

StrawberriesSuiteConfig strawberries_config_of(const SuiteRun& run) {
  return {.seed = run.seed, .quick = run.quick, .runs = run.runs, .sets = run.sets};
}

}  // namespace

BenchSuite bench_strawberries() {
  return {
      .name = "strawberries",
      .help =
          "Place, size, volume and cut point of strawberries on a bed, by ours, by the paper's "
          "rule and by simpler bodies on the same captures of simulated depth cameras. Boxes and "
          "masks are the true ones: there is no detector. No real bed has confirmed it.",
      .takes = {"--quick", "--runs", "--set", "--shard", "--only"},
      .jobs =
          [](const SuiteRun& run) { return strawberries_suite_jobs(strawberries_config_of(run)); },
      .page =
          [](const SuiteRun& run, const std::vector<ShardResult>& results) {
            ScoreFile file = scores_of_shards(results, "strawberries", run.seed);
            append({.scores = strawberries_pooled_rows(file, run.seed)}, file);
            return suite_page(std::move(file));
          },
      .plots = [](SeedsReport& report) { add_strawberries_plots(report); }};
}

}  // namespace cousin
