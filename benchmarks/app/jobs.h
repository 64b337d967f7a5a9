#pragma once

#include "benchmarks/app/options.h"

namespace cousin {

/// Entry of the module that holds all verbs. Returns the exit code; never throws.
/// argc and argv are the command line as given, for the report.
using RunJob = int(const Options* options, int argc, const char* const* argv);
inline constexpr const char* kRunJobSymbol = "cousin_run_job";

}  // namespace cousin
