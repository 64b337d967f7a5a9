// The row of `cousin bench calibration`.
#include <string>
#include <utility>

#include "benchmarks/loop/bench_suite.h"
#include "benchmarks/suites/calibration/calibration_suite.h"
#include "benchmarks/suites/calibration/studies.h"

namespace cousin {
namespace {

StudiesConfig studies_config(const SuiteRun& run) {
  StudiesConfig config;
  config.seed = run.seed;
  config.quick = run.quick;
  if (run.runs > 0) config.runs = run.runs;
  return config;
}

/// What is verified on computed corners, then the studies.
std::vector<ShardJob> calibration_jobs(const SuiteRun& run) {
  GridJob verified = jobs_of({{run.quick ? "verified.quick" : "verified", {}}}).front();
  const std::string key =
      std::string(COUSIN_VERSION) + "/" + std::to_string(run.seed) + "/" + verified.name + ".json";
  std::vector<ShardJob> jobs = {shard_of(std::move(verified), key, [run] {
    return to_json(calibration_suite(run.seed, run.quick, run.progress));
  })};
  add_all(study_jobs(studies_config(run)), jobs);
  return jobs;
}

}  // namespace

BenchSuite bench_calibration() {
  return {.name = "calibration",
          .help =
              "What a calibration is worth. Solvers on the same corners, predicted intervals and "
              "seconds are on computed corners with normal noise: verified, and cross-checked with "
              "OpenCV and mrcal. The studies photograph boards through a sensor's model, find them "
              "and hold the lens found against the true one.",
          .takes = {"--quick", "--shard", "--only", "--runs"},
          .jobs = calibration_jobs,
          .page =
              [](const SuiteRun& run, const std::vector<ShardResult>& results) {
                ScoreFile scores = scores_of_shards(results, "calibration", run.seed);
                add_all(study_rows(scores.scores, studies_config(run)), scores.scores);
                return suite_page(std::move(scores));
              },
          .plots =
              [](SeedsReport& report) {
                add_all(study_plots(report.scores.scores), report.lines);
                add_all(study_times(report.scores.scores), report.curves);
              }};
}

}  // namespace cousin
