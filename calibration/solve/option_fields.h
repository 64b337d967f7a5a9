#pragma once

#include <string>
#include <vector>

#include "calibration/solve/calibrate.h"
#include "sim/config/fields.h"

namespace cousin {

/// Options that calibrations and bundle adjustments share. Each field points at its value.

/// "none", "huber" or "cauchy".
TextField loss_field(RobustLoss& loss);
/// Names parted by commas.
TextField names_field(std::vector<std::string>& names);

}  // namespace cousin
