#pragma once

#include <string>

#include "benchmarks/score/scores.h"
#include "benchmarks/tools/fit_sensor/sensor_fit.h"

namespace cousin {

/// A fit as rows of suite "fit-sensor": the laws, each wall, each brightness, what was held out,
/// and a row "solved" (1 or 0). Rejected parts are not_solved. header.more holds the verdict and
/// the reasons ("problem_1", ...).
ScoreFile fit_rows(const SensorFit& fit);

/// For a terminal: laws, walls, flat fields, verdict.
std::string fit_table(const SensorFit& fit);

}  // namespace cousin
