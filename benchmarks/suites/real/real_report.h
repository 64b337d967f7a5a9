#pragma once

#include <filesystem>
#include <string>

#include "benchmarks/suites/real/real_suite.h"

namespace cousin {

/// The page of the suite: pictures, shapes to turn, distributions and tables in one self-contained
/// HTML file, written whole or not at all.
void write_real_report(const std::filesystem::path& file, const RealResult& result,
                       const std::string& command_line);

}  // namespace cousin
