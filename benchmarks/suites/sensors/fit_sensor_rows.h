#pragma once

#include <cstdint>
#include <vector>

#include "benchmarks/score/scores.h"

namespace cousin {

/// fit-sensor against devices whose numbers it does not know: truth, estimate and interval of each
/// number of one device; coverage and held-out sigma over many; wrong models, which it must reject;
/// and the full active-stereo model as a device, whose fitted fast model is held to it at a
/// distance that was not recorded.
std::vector<ScoreRow> fit_sensor_rows(std::uint64_t seed, bool quick);

}  // namespace cousin
