#pragma once

#include <span>

#include "benchmarks/score/trait_statistics.h"
#include "sim/types/rng.h"

namespace cousin {

/// Spearman's rank correlation of paired values, ties at their mean rank, with the 95 % percentile
/// interval over pairs drawn with replacement. NaN for fewer than three pairs or values that are
/// all alike. Deterministic in (a, b, rng).
/// @throws std::invalid_argument if the lengths differ or a value is NaN.
WithInterval rank_correlation(std::span<const double> a, std::span<const double> b, Rng rng,
                              const BootstrapConfig& config = {});

}  // namespace cousin
