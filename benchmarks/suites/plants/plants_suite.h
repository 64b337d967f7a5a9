#pragma once

#include <cstdint>

#include "benchmarks/loop/simulate.h"
#include "benchmarks/score/scores.h"

namespace cousin {

/// Fruits and trusses: sizes drawn against the published mean and spread with their sources in the
/// metric's name, red shares asked for and reached, seconds to build, and trusses at rest: status,
/// overlap and seconds; berry_rows and orchard_rows.
/// @param quick  fewer trusses and fruits built
ScoreFile plants_suite(std::uint64_t seed, bool quick, const Progress& progress = {});

}  // namespace cousin
