#pragma once

#include <cstdint>
#include <vector>

#include "benchmarks/score/scores.h"

namespace cousin {

/// A ZED's depth from its two colour images, by the pipeline's function on the reported
/// calibration, of a printed wall: exponent of sigma_Z over distance, bias of the disparity with a
/// calibration that is true, and with one that is wrong the error of the depth against what the
/// wrong numbers make of the true disparity.
/// @param quick  half as many distances
std::vector<ScoreRow> passive_stereo_rows(std::uint64_t seed, bool quick);

}  // namespace cousin
