#pragma once

#include <string>

#include "benchmarks/score/scores.h"

namespace cousin {

/// The sentences that a page of results begins with: how many of how many specimens are measured
/// and how wrong, with 95 % intervals, of `ours` or else of the first method there is; and how many
/// numbers keep their limit. "" where rows say neither.
std::string verdict(const ScoreFile& file);

}  // namespace cousin
