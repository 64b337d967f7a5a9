#pragma once

#include <cstdint>
#include <vector>

#include "benchmarks/score/scores.h"

namespace cousin {

/// Questions about calibrations that truth settles, with verdicts; corners are computed.
/// - OpenCV 4.6's deviations against the scatter of what it finds, and corrected.
/// - Reprojection errors that are alike where true errors are not: boards tilted little and much.
/// - k3 fitted to corners of the middle: how many lenses fold inside the image, and who says so.
/// Where OpenCV's ChArUco corners lie is among detection_rows.h.
/// @param quick  fewer calibrations behind each number, and wider limits for it
std::vector<ScoreRow> exhibit_rows(std::uint64_t seed, bool quick);

}  // namespace cousin
