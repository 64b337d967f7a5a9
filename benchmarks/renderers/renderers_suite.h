#pragma once

#include <cstdint>
#include <filesystem>

#include "benchmarks/metrics/scores.h"
#include "benchmarks/seeds/simulate.h"

namespace cousin {

/// The path tracer against closed forms, and beside Cycles on the leafy scene: agreement of geometry
/// and mean radiance, error against seconds at several sample counts, plain and adaptive, and the
/// ratio of the times to one error. Without Blender the rows beside it say `not_built`.
/// @param folder  for Blender's files.
ScoreFile renderers_suite(std::uint64_t seed, const std::filesystem::path& folder, int threads,
                          bool quick, const Progress& progress = {});

}  // namespace cousin
