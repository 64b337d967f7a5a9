// The row of `cousin bench real`.
#include "benchmarks/loop/bench_suite.h"
#include "benchmarks/suites/real/real_report.h"
#include "benchmarks/suites/real/real_suite.h"

namespace cousin {

BenchSuite bench_real() {
  return {.name = "real",
          .help =
              "Real captures: nobody measured the specimens, so this is agreement, not "
              "accuracy.",
          .takes = {"--quick"},
          .page = [](const SuiteRun& run, const std::vector<ShardResult>&) {
            RealResult result = real_suite(run.real_data, run.out, run.quick, run.progress);
            SuitePage page = suite_page(result.file);
            page.write_own = [run, result](const ScoreFile& scores) {  // with its pictures
              RealResult finished = result;
              finished.file = scores;
              write_real_report(run.out / "report.html", finished, run.command_line);
            };
            return page;
          }};
}

}  // namespace cousin
