// The row of `cousin bench light`.
#include <filesystem>
#include <string>
#include <thread>
#include <utility>

#include "benchmarks/loop/bench_suite.h"
#include "benchmarks/suites/light/light_page.h"
#include "benchmarks/suites/light/light_suite.h"

namespace cousin {
namespace {

SuitePage light_page(const SuiteRun& run, const std::vector<ShardResult>&) {
  LightConfig config;
  config.seed = run.seed;
  config.folder = std::filesystem::absolute(run.out);
  config.threads =
      run.threads > 0 ? run.threads : static_cast<int>(std::thread::hardware_concurrency());
  if (run.quick) config = quick(config);
  LightResult result = light_suite(config, run.progress);
  SuitePage page = suite_page(std::move(result.file));
  page.report.summary =
      std::string(
          "The path tracer beside closed forms and beside Cycles: agreement, error against "
          "time. Cross-checked with Cycles; errors are ") +
      (run.quick ? "the noise between two images of each."
                 : "each renderer's own, against its own converged image.");
  page.report.config_toml = to_toml(fields(config));
  keep_scene(page.report, result.pictures, run.out);
  return page;
}

}  // namespace

BenchSuite bench_light() {
  return {.name = "light",
          .old_name = "renderers",
          .help = "The path tracer beside closed forms and beside Cycles.",
          .takes = {"--quick"},
          .page = light_page,
          .plots = [](SeedsReport& report) {
            add_all(light_curves(report.scores.scores), report.curves);
          }};
}

}  // namespace cousin
