#pragma once

#include "calibration/boards/target_detection.h"
#include "calibration/boards/target_view.h"
#include "sim/types/calibration_target.h"
#include "sim/types/image.h"

namespace cousin {

/// The seed board as a calibration target, by detect_board (board_detection.h), which is told a
/// lens without distortion: it places the print by homographies, to which a focal length does not
/// matter, and corners by windows about them. Refused: a board without markers, which looks the
/// same after a quarter turn.
/// @param light  linear, black to white anywhere in it
/// @throws std::invalid_argument for a target of another kind
TargetView find_seed_board(const Image<float>& light, const CalibrationTarget& target,
                           const TargetDetectionConfig& config = {});

}  // namespace cousin
