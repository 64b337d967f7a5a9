// The row of `cousin bench shapes`.
#include "benchmarks/loop/bench_suite.h"
#include "benchmarks/suites/shapes/shapes_suite.h"

namespace cousin {
namespace {

ShapesSuiteConfig shapes_config(const SuiteRun& run) {
  return {.seed = run.seed, .quick = run.quick, .runs = run.runs, .sets = run.sets};
}

}  // namespace

BenchSuite bench_shapes() {
  return {.name = "shapes",
          .help =
              "Bodies of five shapes that no prior was tuned on, each grown its own way: bias of "
              "their heights, and whether 95 % intervals hold.",
          .takes = {"--quick", "--runs", "--set", "--shard", "--only"},
          .jobs = [](const SuiteRun& run) { return shapes_suite_jobs(shapes_config(run)); },
          .page =
              [](const SuiteRun& run, const std::vector<ShardResult>& results) {
                ScoreFile file = scores_of_shards(results, "shapes", run.seed);
                append({.scores = shapes_pooled_rows(file.specimens, run.seed)}, file);
                return suite_page(std::move(file));
              }};
}

}  // namespace cousin
