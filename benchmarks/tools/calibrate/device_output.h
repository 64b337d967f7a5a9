#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "benchmarks/tools/calibrate/calibration_run.h"

namespace cousin {

/// What a run says of the device beside its lenses: line delay, registration, depth. Private to
/// benchmarks/tools/calibrate.

/// Adds "rolling_shutter", "registration" and "depth", those that the run has.
void add_device(const CalibrationRun& run, nlohmann::ordered_json& json);

/// The same for a person: lines of the table, in millimetres and microseconds.
std::string device_table(const CalibrationRun& run);

/// And sentences of the report's summary, each after a space.
std::string device_sentences(const CalibrationRun& run);

}  // namespace cousin
