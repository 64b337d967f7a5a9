#pragma once

#include "calibration/boards/target_view.h"
#include "sim/types/calibration_target.h"
#include "sim/types/image.h"

namespace cousin {

/// Corners of a chessboard as OpenCV's tutorial finds them: findChessboardCorners and cornerSubPix
/// in 11 x 11 windows, 30 steps or a thousandth of a pixel, on the picture's 8-bit grey. Points are
/// in OpenCV's order; which end is first is its own choice. `not_seen` where it finds none.
/// @throws std::invalid_argument if the target is no chessboard.
TargetView find_corners_by_opencv(const Image<Rgb8>& picture, const CalibrationTarget& target);

}  // namespace cousin
