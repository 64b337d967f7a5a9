#pragma once

#include <cstdint>
#include <vector>

#include "benchmarks/score/scores.h"

namespace cousin {

/// What the numbers that the Strawberries paper prints of its calibration can mean: each definition
/// of a reprojection error against the deviation of corners that gives it, and for each cause of
/// calibration_causes.h how far p1 and the principal point go, what the reprojection error then is,
/// and how many copies are as far off as the paper's.
/// @param quick  fewer copies a row
std::vector<ScoreRow> cause_rows(std::uint64_t seed, bool quick);

}  // namespace cousin
