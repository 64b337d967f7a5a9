#pragma once

#include <string>

#include "calibration/solve/calibration_solvers.h"

namespace cousin {

/// OpenCV's flags for what is fixed of a lens; a message where it cannot fix just that. Private to
/// calibration.
std::string opencv_flags(const ProblemLens& lens, int& flags);

/// Two cameras by cv::stereoCalibrate, from each camera's own cv::calibrateCamera. It takes the
/// same points of both cameras in every frame: others are dropped from the problem. It gives no
/// poses: these are found afterwards, lenses and places held.
SolverRun solve_stereo_with_opencv(CalibrationProblem& problem, CalibrationState& state);

}  // namespace cousin
