#pragma once

#include "benchmarks/tools/calibrate/calibration_run.h"

namespace cousin {

/// Sets `run.registration` where a dataset has a colour camera and a depth camera's left imager,
/// in whose pixels its depth is, and the run's result a covariance.
void compare_with_reported(CalibrationRun& run);

/// Sets `run.depth` where a dataset has depth in one of the cameras' pixels and the run's result a
/// covariance. @throws std::runtime_error naming a depth image that cannot be read
void check_depth_on_boards(CalibrationRun& run);

/// Adds a warning for a camera whose rows are read one after the other, where it is taken as if
/// they were not.
void warn_of_shutters(CalibrationRun& run);

}  // namespace cousin
