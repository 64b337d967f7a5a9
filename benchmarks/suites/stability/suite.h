#pragma once

#include "benchmarks/loop/simulate.h"
#include "benchmarks/score/scores.h"

namespace cousin {

/// The stiff and extreme cases of every module: measured quantity, limit, value, pass or fail.
/// @param quick  fewer rays from inside the watertight seeds and coarser contact and stem tables
ScoreFile stability_suite(bool quick, const Progress& progress = {});

}  // namespace cousin
