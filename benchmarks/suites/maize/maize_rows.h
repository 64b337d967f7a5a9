#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "benchmarks/score/scores.h"

namespace cousin {

/// Statistics of each group (SpecimenRow::scene: stages pooled, or what is special), case
/// (SpecimenRow::dataset) and method over all captures: TRAIT.rmse, .bias, .median_error,
/// .median_share, .coverage_95, .width_over_rmse (mean width of the 95 % interval), .solved; and of
/// each method against the paper's on the same specimens: .rmse_ratio, .paired_t, .paired_t_p.
/// Internodes of 20 mm or more: the paper's are 63 and 99 mm, and nodes in the crown are one to any
/// detector.
std::vector<ScoreRow> maize_pooled_rows(std::span<const SpecimenRow> specimens, std::uint64_t seed);

/// Gives the rows that have a limit the status pass or fail.
void hold_maize_to_limits(std::vector<ScoreRow>& rows);

}  // namespace cousin
