// The row of `cousin bench cousins`.
#include "benchmarks/loop/bench_suite.h"
#include "benchmarks/suites/seeds/cousins_suite.h"

namespace cousin {
namespace {

CousinsSuiteConfig cousins_config(const SuiteRun& run) {
  CousinsSuiteConfig config;
  config.seed = run.seed;
  config.quick = run.quick;
  config.sets = run.sets;
  return config;
}

}  // namespace

BenchSuite bench_cousins() {
  return {
      .name = "cousins",
      .help =
          "The seeds' errors on scenes that differ from the reference along one axis at a "
          "time: shape, growth, texture, light, sensor. Ranges are free: they say what was "
          "tried, not what is found in the world.",
      .takes = {"--quick", "--set", "--shard", "--only"},
      .jobs =
          [](const SuiteRun& run) { return cousins_suite_jobs(cousins_config(run), run.progress); },
      .page =
          [](const SuiteRun& run, const std::vector<ShardResult>& results) {
            const CousinsSuiteConfig config = cousins_config(run);
            SuitePage page = suite_page(pool_cousins_suite(results, config));
            page.report.config_toml = cousins_toml(config);
            return page;
          },
      .plots =
          [](SeedsReport& report) { add_all(cousins_plots(report.scores.scores), report.lines); }};
}

}  // namespace cousin
