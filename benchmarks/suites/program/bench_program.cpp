// The row of `cousin bench program`.
#include <filesystem>

#include "benchmarks/loop/bench_suite.h"
#include "benchmarks/suites/program/program_suite.h"

namespace cousin {

BenchSuite bench_program() {
  return {.name = "program",
          .help = "The program as a user meets it, in a process of its own.",
          .page = [](const SuiteRun& run, const std::vector<ShardResult>&) {
            return suite_page(program_suite(std::filesystem::read_symlink("/proc/self/exe"),
                                            run.out, run.progress));
          }};
}

}  // namespace cousin
