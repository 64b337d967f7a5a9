#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "benchmarks/metrics/scores.h"

namespace cousin {

/// Depth cameras against the laws of stereo and the published figures: exponent of sigma_Z over
/// distance, sub-pixel ripple, fill over distance, light and incidence, temporal against spatial
/// noise, edges, least depth of each mode, width of the invalid band, the fast model against the
/// full one, and images a second.
/// @param quick  fewer frames and walls; light, incidence, model and speed for the D457 only
std::vector<ScoreRow> depth_rows(std::uint64_t seed, bool quick);
/// The rows of one preset. @throws std::invalid_argument for an unknown name.
std::vector<ScoreRow> depth_rows_of(const std::string& rig, std::uint64_t seed, bool quick);

}  // namespace cousin
