// The row of `cousin bench phone`.
#include "benchmarks/loop/bench_suite.h"
#include "benchmarks/suites/phone/phone_suite.h"

namespace cousin {
namespace {

PhoneSuiteConfig config_of(const SuiteRun& run) {
  return {.seed = run.seed, .quick = run.quick, .runs = run.runs, .sets = run.sets};
}

}  // namespace

BenchSuite bench_phone() {
  return {.name = "phone",
          .help =
              "The same seeds by a calibrated phone, by one that nobody has calibrated, through "
              "H.264 and on a bent sheet. The phone is simulated; no real one has confirmed it.",
          .takes = {"--quick", "--runs", "--set", "--shard", "--only"},
          .jobs = [](const SuiteRun& run) { return phone_suite_jobs(config_of(run)); },
          .page =
              [](const SuiteRun& run, const std::vector<ShardResult>& results) {
                ScoreFile file = scores_of_shards(results, "phone", run.seed);
                append({.scores = phone_pooled_rows(file.specimens, run.seed)}, file);
                return suite_page(std::move(file));
              }};
}

}  // namespace cousin
