#pragma once

#include <cstdint>
#include <string>

#include "benchmarks/score/scores.h"
#include "benchmarks/suites/calibration/corner_views.h"

namespace cousin {

/// A row of this suite over one thing, without a number yet.
ScoreRow calibration_row(const std::string& scene, const std::string& case_name,
                         const std::string& method, std::uint64_t seed);

/// The row with a number that must not be above a limit; the limit goes into the metric's name.
ScoreRow at_most(ScoreRow row, const std::string& metric, const std::string& unit, double value,
                 double limit);

/// The row of what is not built in, and why.
ScoreRow not_built(ScoreRow row, const std::string& reason);

/// Corners as corner_views.h has them, from 0.2 to 0.45 m away.
CornerViewsConfig close_views();

}  // namespace cousin
