#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "benchmarks/score/scores.h"
#include "sim/types/rng.h"

namespace cousin {

/// Two calibrations of one camera between which somebody chooses.
struct CalibrationPair {
  double criterion[2] = {0, 0};  ///< of each: the one with the lower is taken
  double error[2] = {0, 0};      ///< true, of each
};
/// How good choosing by the criterion is. Rows "share of choices that take the better one" with
/// Wilson's interval, where 0.5 is what a coin does, and "true error of the one taken over the
/// better one's", its mean and largest. `row` gives suite, scene, case, method, seed.
std::vector<ScoreRow> choice_scores(const ScoreRow& row, std::span<const CalibrationPair> pairs);

/// Choosing between calibrations by the lower reprojection error, as the Strawberries paper does,
/// and by the lower predicted deviation of the projection; on computed corners of cameras whose
/// owners go about it in all ways. And the rank correlation of each criterion with the true
/// projection error over all of them.
/// @param quick  fewer owners
std::vector<ScoreRow> choice_rows(std::uint64_t seed, bool quick);

}  // namespace cousin
