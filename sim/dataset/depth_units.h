#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "sim/types/capture.h"

namespace cousin {

/// Private to sim/dataset: whether depth was read in the right unit.

enum class DepthMeasure { units, metres };

/// Median of the depth that a sensor of a capture has, over all frames (of more than a million
/// pixels evenly many); nothing if there is none.
std::optional<double> median_depth(const Capture& capture, std::size_t sensor,
                                   DepthMeasure measure);

/// "Give --depth-unit, metres a unit: 0.0002 (TUM: 0.4 m), ...": what usual units make of a median.
std::string usual_depth_units(double median_units);

/// @throws std::runtime_error naming `place`, the median and the limits unless it is between 1 cm
/// and 20 m, or there is no depth. @param advice  "" = usual_depth_units
void check_median_depth(const Capture& capture, std::size_t sensor, const std::string& place,
                        const std::string& advice = "");

}  // namespace cousin
