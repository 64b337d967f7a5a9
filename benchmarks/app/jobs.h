#pragma once

#include "benchmarks/app/options.h"

namespace cousin {

/// Entry of a module. Returns the exit code; never throws.
/// argc and argv are the command line as given, for the report.
using RunJob = int(const Options* options, int argc, const char* const* argv);
inline constexpr const char* kRunJobSymbol = "cousin_run_job";

/// What the entry of every module does.
int run_and_report(const Options* options, int argc, const char* const* argv);

}  // namespace cousin
