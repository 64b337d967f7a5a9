// The row of `cousin bench sfm`.
#include <filesystem>

#include "benchmarks/loop/bench_suite.h"
#include "benchmarks/suites/sfm/sfm_suite.h"

namespace cousin {

BenchSuite bench_sfm() {
  return {.name = "sfm",
          .help =
              "Poses by COLMAP 3.8 before and after our adjustment, against exact ones. "
              "COLMAP's results vary with its threads, whose number is fixed here, and with "
              "its build.",
          .takes = {"--quick", "--shard", "--only"},
          .jobs = [](const SuiteRun& run) {
            SfmSuiteConfig config;
            config.seed = run.seed;
            config.quick = run.quick;
            config.folder = std::filesystem::absolute(run.out / "colmap");
            config.neutral = run.real_data / ".." / "data" / "splat_neutral";
            return sfm_suite_jobs(config, run.progress);
          }};
}

}  // namespace cousin
