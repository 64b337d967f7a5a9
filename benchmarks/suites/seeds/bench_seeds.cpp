// The row of `cousin bench seeds`.
#include "benchmarks/loop/bench_suite.h"
#include "benchmarks/loop/result_folder.h"
#include "benchmarks/suites/seeds/paper_tables.h"
#include "benchmarks/suites/seeds/suite.h"
#include "benchmarks/suites/seeds/trained_plots.h"

namespace cousin {
namespace {

SeedsSuiteConfig seeds_config(const SuiteRun& run) {
  SeedsSuiteConfig config;
  config.seed = run.seed;
  config.quick = run.quick;
  if (run.runs > 0) config.runs = run.runs;
  config.attribution = run.attribution;
  config.sets = run.sets;
  config.captures = run.captures;
  config.lpips = run.lpips;
  config.report = report_scenes_folder(run.out);
  config.unfinished = run.unfinished();
  return config;
}

SuitePage seeds_page(const SuiteRun& run, const std::vector<ShardResult>& results) {
  const SeedsSuiteConfig config = seeds_config(run);
  SuitePage page = suite_page(pool_seeds_suite(results, config));
  page.report.config_toml = suite_toml(config);
  show_scenes(results, config.report, page.report);
  return page;
}

}  // namespace

BenchSuite bench_seeds() {
  return {
      .name = "seeds",
      .help = kMeasuredAgainstTruth,
      .takes = {"--quick", "--set", "--captures", "--shard", "--only", "--attribution", "--runs",
                "--lpips"},
      .jobs = [](const SuiteRun& run) { return seeds_suite_jobs(seeds_config(run), run.progress); },
      .page = seeds_page,
      .limits = [](const SuiteRun& run,
                   ScoreFile& scores) { hold_seeds_suite(seeds_config(run), scores); },
      .plots =
          [](SeedsReport& report) {
            add_all(trained_plots(report.scores.scores), report.lines);
            add_all(seeds_paper_tables(report.scores.scores), report.tables);
          },
      .text = summary_table};
}

}  // namespace cousin
