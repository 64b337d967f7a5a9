#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "benchmarks/score/scores.h"

namespace cousin {

/// One preset's depth camera against the laws of stereo and the published figures: exponent of
/// sigma_Z over distance, sub-pixel ripple, fill over distance, light and incidence, temporal
/// against spatial noise, edges, least depth of each mode, width of the invalid band, and the fast
/// model against the full one.
/// @param quick  fewer frames and walls; light, incidence and model for the D457 only
/// @throws std::invalid_argument for an unknown name.
std::vector<ScoreRow> depth_rows_of(const std::string& rig, std::uint64_t seed, bool quick);
/// Images a second of the D457, and what its rendering adds to the imager's noise.
std::vector<ScoreRow> depth_speed_rows(std::uint64_t seed, bool quick);

}  // namespace cousin
