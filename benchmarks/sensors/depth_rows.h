#pragma once

#include <cstdint>
#include <vector>

#include "benchmarks/metrics/scores.h"

namespace cousin {

/// Depth cameras against the laws of stereo and the published figures: exponent of sigma_Z over
/// distance, sub-pixel ripple, fill over distance, light and incidence, temporal against spatial
/// noise, edges, least depth of each mode, width of the invalid band, the fast model against the
/// full one, and images a second.
std::vector<ScoreRow> depth_rows(std::uint64_t seed, bool quick);

}  // namespace cousin
