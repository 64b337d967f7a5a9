#pragma once

#include "benchmarks/calibrate/calibration_run.h"

namespace cousin {

/// Adds what a person should know before using the result: problems, with which it is not usable,
/// and warnings. Private to benchmarks/calibrate.
void judge(CalibrationRun& run);

}  // namespace cousin
