#pragma once

#include <cstdint>
#include <vector>

#include "benchmarks/loop/report_scene.h"
#include "benchmarks/report/report.h"
#include "benchmarks/score/scores.h"

namespace cousin {

/// Plots of the rows of suite "sensors", read by metric and case, so that whoever adds rows of
/// those names is on them: photon transfer and sigma_Z with their laws, fill over distance, light
/// and incidence, ripple, spatial and temporal noise. Of rows of other suites: none.
std::vector<LinePlot> sensors_plots(const std::vector<ScoreRow>& rows);

/// What a D457 makes of a part of the leafy scene in dim light: the left infrared image with its
/// dots, depth, and why pixels have none.
ReportScene sensors_pictures(std::uint64_t seed);

}  // namespace cousin
