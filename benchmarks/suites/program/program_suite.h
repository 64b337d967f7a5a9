#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "benchmarks/score/scores.h"

namespace cousin {

/// The program as a user meets it, each row held to its limit: the median start of
/// `cousin --help` (0.1 s), and one `cousin run seeds` with its defaults (10 seeds, 60 views of
/// 1280 x 720) in a process of its own: wall time (240 s) and peak memory (2 GB).
/// @param program  the executable to start
/// @param out      folder for what the run writes
/// @throws std::runtime_error if the program cannot be started.
ScoreFile program_suite(const std::filesystem::path& program, const std::filesystem::path& out,
                        const std::function<void(const std::string&, int, int)>& progress = {});

}  // namespace cousin
