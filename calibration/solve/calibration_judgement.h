#pragma once

#include "calibration/solve/calibrate.h"

namespace cousin {

/// Names in `result` what its covariance says is not determined, and lenses that fold inside their
/// image, with the reason; the status is then `not_determined`. Private to calibration.
void judge_calibration(const CalibrationInput& input, const CalibrationConfig& config,
                       CalibrationResult& result);

}  // namespace cousin
