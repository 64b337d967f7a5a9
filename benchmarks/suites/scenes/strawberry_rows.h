#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "benchmarks/score/scores.h"

namespace cousin {

/// Strawberries of `cousin bench scenes`: seconds to settle and to build a stretch and what
/// overlaps there (limits 10 s, 1 s, 0.5 mm), fruits and maturity beside the paper's 1158 images
/// [Strawberries 2.1], and seconds of a labelled 640 x 640 image of four samples a pixel from
/// stretches at rest, with what share is what (limit 4.5 s: 1000 in 75 minutes).
/// @param quick  3 stretches and 4 images instead of 12 and 20
std::vector<ScoreRow> strawberry_rows(
    std::uint64_t seed, bool quick,
    const std::function<void(const std::string&, int, int)>& progress);

}  // namespace cousin
