#pragma once

#include <cstdint>

#include "benchmarks/suites/calibration/corner_views.h"
#include "calibration/solve/calibration_uncertainty.h"

namespace cousin {

/// Shares of true projection errors that lie within the predicted 68 and 95 % intervals.
struct Coverage {
  double within_68 = 0, within_95 = 0;
  int calibrations = 0;  ///< those with status ok
  int failed = 0;
  std::int64_t intervals = 0;
};

struct CoverageConfig {
  LensModel model = LensModel::opencv5;
  CornerViewsConfig views;
  ProjectionGauge gauge = ProjectionGauge::best_fit;
  double distance_m = std::numeric_limits<double>::infinity();
  int calibrations = 1000;
};

/// Calibrates the same views again and again with new noise (Ceres), and holds the error of the
/// projection at five pixels, in x and y, against its predicted deviation. The error is that of the
/// gauge: after the best motion over the image, or after the mean motion of the true frames.
/// Parallel over calibrations, the same on any number of threads.
Coverage projection_coverage(const CoverageConfig& config, const Rng& rng);

}  // namespace cousin
