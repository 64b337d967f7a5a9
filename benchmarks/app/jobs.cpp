#include "benchmarks/app/jobs.h"

#include <pmmintrin.h>
#include <tbb/global_control.h>
#include <xmmintrin.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <new>
#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>
#include <stdexcept>
#include <string>
#include <thread>

#include "benchmarks/app/commands.h"
#include "benchmarks/app/terminal.h"
#include "benchmarks/loop/stage_files.h"
#include "perception/pipelines/seeds.h"
#include "sim/process/interruption.h"
#include "sim/types/last_read.h"
#include "sim/types/memory_limit.h"
#include "sim/types/not_built.h"
#include "sim/types/stage_clock.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace {

int fail(ExitCode code, const std::string& what) {
  print_message("cousin: " + what);
  return static_cast<int>(code);
}

/// No bare std::bad_alloc: what was done, what was read, and what can be asked for instead.
int fail_for_memory(const Options& options) {
  const std::span<const Verb> verbs = module_verbs();
  const auto verb = std::find_if(verbs.begin(), verbs.end(),
                                 [&](const Verb& v) { return options.verb == v.name; });
  const bool is_inputs = verb != verbs.end() && verb->reads == Reads::input;
  std::string what = options.verb;
  for (const std::string& argument : options.arguments) what += " " + argument;
  what += ": memory is not enough; " + std::to_string(std::llround(current_rss_mb())) +
          " MiB are in use";
  if (const std::string file = last_read(); !file.empty())
    what += ", and the file read last is " + file;
  what += is_inputs ? ". Give fewer or smaller files" : ". Ask for fewer frames or fewer pixels";
  return fail(is_inputs ? ExitCode::bad_input : ExitCode::internal, what);
}

/// Whether a stage failed since the program lacks it.
bool is_not_built(const StageError& error) {
  try {
    std::rethrow_if_nested(error);
  } catch (const NotBuilt&) {
    return true;
  } catch (...) {
  }
  return false;
}

std::uint64_t memory_limit_of(const Options& options) {
  constexpr double kGiB = 1024.0 * 1024 * 1024;
  return static_cast<std::uint64_t>(options.memory_limit_gib * kGiB);
}

int run_job(const Options& options, int argc, const char* const* argv) {
  clean_up_when_interrupted();
  set_memory_limit(memory_limit_of(options));
  start_rss_mb();  // what the work takes is counted from here
  const int threads = options.threads > 0
                          ? options.threads
                          : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(threads));
  cv::setNumThreads(1);  // parallelism is over frames, and OpenCV's own would change sums
  std::string command_line;
  for (int i = 0; i < argc; ++i) {
    const std::string word = i == 0 ? "cousin" : readable_utf8(argv[i]);
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

int run_and_report(const Options* options, int argc, const char* const* argv) {
  try {
    return run_job(*options, argc, argv);
  } catch (const std::bad_alloc&) {
    return fail_for_memory(*options);
  } catch (const std::length_error&) {  // a vector of more than there can be
    return fail_for_memory(*options);
  } catch (const cv::Exception& error) {
    if (error.code == cv::Error::StsNoMem) return fail_for_memory(*options);
    return fail(ExitCode::internal, error.what());
  } catch (const StageError& error) {
    if (is_not_built(error)) return fail(ExitCode::usage, error.what());
    const bool is_input = is_fault_of_input(error, options->stages);
    return fail(is_input ? ExitCode::bad_input : ExitCode::internal, error.what());
  } catch (const std::invalid_argument& error) {
    return fail(ExitCode::usage, error.what());
  } catch (const std::runtime_error& error) {
    return fail(ExitCode::bad_input, error.what());
  } catch (const std::exception& error) {
    return fail(ExitCode::internal, error.what());
  }
}

}  // namespace cousin
