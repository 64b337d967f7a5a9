// The row of `cousin bench seedlings`.
#include "benchmarks/loop/bench_suite.h"
#include "benchmarks/suites/seedlings/seedlings_page.h"
#include "benchmarks/suites/seedlings/seedlings_suite.h"

namespace cousin {
namespace {

SeedlingsSuiteConfig seedlings_config(const SuiteRun& run) {
  SeedlingsSuiteConfig config;
  config.seed = run.seed;
  config.quick = run.quick;
  if (run.runs > 0) config.samples = run.runs;
  config.lpips = run.lpips;
  config.report = report_scenes_folder(run.out);
  config.unfinished = run.unfinished();
  return config;
}

SuitePage seedlings_page(const SuiteRun& run, const std::vector<ShardResult>& results) {
  const SeedlingsSuiteConfig config = seedlings_config(run);
  SuitePage page = suite_page(pool_seedlings_suite(results, config));
  page.report.config_toml = seedlings_toml(config);
  show_scenes(results, config.report, page.report);
  return page;
}

}  // namespace

BenchSuite bench_seedlings() {
  return {.name = "seedlings",
          .help =
              "Trays of watermelon seedlings under three lights, reconstructed from hand-held "
              "photographs with exact poses: how well Gaussians and a radiance field show the "
              "views they were trained on and others, over the time they took and over what "
              "the views cover. Published numbers are the Seedlings paper's tables 2 to 4: "
              "other plants, other photographs, a graphics card; its PSNR is taken to be of "
              "views trained on.",
          .takes = {"--quick", "--shard", "--only", "--runs", "--lpips"},
          .jobs = [](const SuiteRun& run) { return seedlings_suite_jobs(seedlings_config(run)); },
          .page = seedlings_page,
          .limits = [](const SuiteRun& run,
                       ScoreFile& scores) { hold_seedlings_suite(seedlings_config(run), scores); },
          .plots =
              [](SeedsReport& report) {
                add_all(seedlings_plots(report.scores.scores), report.lines);
                add_all(seedlings_curves(report.scores.scores), report.curves);
                add_all(seedlings_tables(report.scores.scores), report.tables);
              },
          .text = [](const std::vector<ScoreRow>&) { return std::string(); }};  // tables say it all
}

}  // namespace cousin
