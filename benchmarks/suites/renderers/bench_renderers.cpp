// The row of `cousin bench renderers`.
#include <filesystem>
#include <string>
#include <thread>
#include <utility>

#include "benchmarks/loop/bench_suite.h"
#include "benchmarks/suites/renderers/renderers_page.h"
#include "benchmarks/suites/renderers/renderers_suite.h"

namespace cousin {
namespace {

SuitePage renderers_page(const SuiteRun& run, const std::vector<ShardResult>&) {
  RenderersConfig config;
  config.seed = run.seed;
  config.folder = std::filesystem::absolute(run.out);
  config.threads =
      run.threads > 0 ? run.threads : static_cast<int>(std::thread::hardware_concurrency());
  if (run.quick) config = quick(config);
  RenderersResult result = renderers_suite(config, run.progress);
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

BenchSuite bench_renderers() {
  return {.name = "renderers",
          .help = "The path tracer beside closed forms and beside Cycles.",
          .takes = {"--quick"},
          .page = renderers_page,
          .plots = [](SeedsReport& report) {
            add_all(renderers_curves(report.scores.scores), report.curves);
          }};
}

}  // namespace cousin
