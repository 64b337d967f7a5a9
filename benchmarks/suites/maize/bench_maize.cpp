// The row of `cousin bench maize`.
#include "benchmarks/loop/bench_suite.h"
#include "benchmarks/suites/maize/maize_rows.h"
#include "benchmarks/suites/maize/maize_suite.h"

namespace cousin {
namespace {

MaizeSuiteConfig maize_config_of(const SuiteRun& run) {
  return {.seed = run.seed, .quick = run.quick, .runs = run.runs, .sets = run.sets};
}

}  // namespace

BenchSuite bench_maize() {
  return {.name = "maize",
          .help =
              "Internodes and heights of maize before a simulated ZED: the paper's method, "
              "triangulation and a smooth stem on the same captures, with errors of a "
              "detector. No network detects nodes here, and no real camera has confirmed it.",
          .takes = {"--quick", "--runs", "--set", "--shard", "--only"},
          .jobs = [](const SuiteRun& run) { return maize_suite_jobs(maize_config_of(run)); },
          .page =
              [](const SuiteRun& run, const std::vector<ShardResult>& results) {
                ScoreFile file = scores_of_shards(results, "maize", run.seed);
                append({.scores = maize_pooled_rows(file.specimens, run.seed)}, file);
                return suite_page(std::move(file));
              },
          .limits = [](const SuiteRun&, ScoreFile& file) { hold_maize_to_limits(file.scores); }};
}

}  // namespace cousin
