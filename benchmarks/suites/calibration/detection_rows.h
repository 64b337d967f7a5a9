#pragma once

#include <cstdint>
#include <vector>

#include "benchmarks/score/scores.h"

namespace cousin {

/// Targets found in rendered boards against where their points truly are: share found, bias,
/// deviation over the Cramer-Rao bound of an 11 x 11 window, and how many lie within the predicted
/// 95 % ellipse, with a blur of 1 px and noise of 1 % of the range; and OpenCV's ChArUco corners,
/// which lie half a pixel off.
/// @param quick  fewer poses and draws of noise
std::vector<ScoreRow> detection_rows(std::uint64_t seed, bool quick);

}  // namespace cousin
