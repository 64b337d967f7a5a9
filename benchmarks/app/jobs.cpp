#include "benchmarks/app/jobs.h"

#include <pmmintrin.h>
#include <tbb/global_control.h>
#include <xmmintrin.h>

#include <cstdio>
#include <exception>
#include <opencv2/core/utility.hpp>
#include <string>
#include <thread>

#include "benchmarks/app/commands.h"
#include "benchmarks/seeds/stage_files.h"
#include "perception/pipelines/seeds.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

int fail(ExitCode code, const std::string& what) {
  std::fprintf(stderr, "cousin: %s\n", what.c_str());
  return static_cast<int>(code);
}

int run_job(const Options& options, int argc, const char* const* argv) {
  start_rss_mb();  // what the work takes is counted from here
  const int threads = options.threads > 0
                          ? options.threads
                          : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(threads));
  cv::setNumThreads(1);  // parallelism is over frames, and OpenCV's own would change sums
  std::string command_line;
  for (int i = 0; i < argc; ++i) {
    const std::string word = i == 0 ? "cousin" : argv[i];
    const bool quote = word.find_first_of(" '\"$&|;<>()*?") != std::string::npos;
    command_line += (i ? " " : "") + (quote ? "'" + word + "'" : word);
  }
  ProgressPrinter progress(options.quiet || options.json);
  const JobContext context{options, command_line, progress};
  for (const Verb& verb : module_verbs()) {
    if (options.verb == verb.name) return static_cast<int>(verb.run(context));
  }
  return fail(ExitCode::usage, "unknown verb \"" + options.verb + "\"");
}

}  // namespace
}  // namespace cousin

extern "C" __attribute__((visibility("default"))) int cousin_run_job(const cousin::Options* options,
                                                                     int argc,
                                                                     const char* const* argv) {
  using cousin::ExitCode;
  try {
    return cousin::run_job(*options, argc, argv);
  } catch (const cousin::StageError& error) {
    const bool is_input = cousin::is_fault_of_input(error, options->stages);
    return cousin::fail(is_input ? ExitCode::bad_input : ExitCode::internal, error.what());
  } catch (const std::invalid_argument& error) {
    return cousin::fail(ExitCode::usage, error.what());
  } catch (const std::runtime_error& error) {
    return cousin::fail(ExitCode::bad_input, error.what());
  } catch (const std::exception& error) {
    return cousin::fail(ExitCode::internal, error.what());
  }
}
