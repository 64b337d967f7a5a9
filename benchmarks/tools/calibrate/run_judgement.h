#pragma once

#include "benchmarks/tools/calibrate/calibration_run.h"

namespace cousin {

/// Adds what a person should know before using the result: problems, with which it is not usable,
/// and warnings. Private to benchmarks/tools/calibrate.
void judge(CalibrationRun& run);

/// Adds a warning for photographs that say of themselves that a viewer turns them: their pixels are
/// used as they are stored.
void warn_of_turned_photos(CalibrationRun& run);

}  // namespace cousin
