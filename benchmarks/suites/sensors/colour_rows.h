#pragma once

#include <cstdint>
#include <vector>

#include "benchmarks/score/scores.h"

namespace cousin {

/// Colour cameras against EMVA 1288's linear model and geometry: photon transfer, fixed pattern,
/// vignetting, lateral colour, rolling-shutter skew, motion blur, and seconds a frame.
std::vector<ScoreRow> colour_rows(std::uint64_t seed, bool quick);

}  // namespace cousin
