#pragma once

#include <cstdint>
#include <vector>

#include "benchmarks/score/scores.h"

namespace cousin {

/// A camera on an arm: 20 poses, 0.1 px, 0.2 mm, 0.02 degrees; motions that leave it open.
std::vector<ScoreRow> hand_eye_rows(std::uint64_t seed, bool quick);

/// Eight cameras in a ring about the board, 500 frames, 60 corners, one solution.
std::vector<ScoreRow> joint_rows(std::uint64_t seed, bool quick);

}  // namespace cousin
