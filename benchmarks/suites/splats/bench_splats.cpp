// The row of `cousin bench splats`.
#include "benchmarks/loop/bench_suite.h"
#include "benchmarks/suites/splats/splats_page.h"
#include "benchmarks/suites/splats/splats_suite.h"

namespace cousin {

BenchSuite bench_splats() {
  return {
      .name = "splats",
      .help =
          "Gaussian splatting on a CPU: core time of each blended pair, wall time of a "
          "training step, and held-out PSNR against wall time on photographs that are not "
          "Cousin's.",
      .takes = {"--quick", "--shard", "--only"},
      .jobs =
          [](const SuiteRun& run) {
            SplatsSuiteConfig config;
            config.photographs =
                (run.real_data / ".." / "data" / "splat_neutral").lexically_normal();
            config.fox = run.real_data / "multiview/instantngp_fox/transforms.json";
            config.chair = run.real_data / "multiview/boofcv_chair";
            config.seed = run.seed;
            config.quick = run.quick;
            return splats_jobs(config);
          },
      .plots =
          [](SeedsReport& report) { add_all(splats_curves(report.scores.scores), report.curves); }};
}

}  // namespace cousin
