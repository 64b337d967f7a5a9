#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "benchmarks/suites/calibration/corner_views.h"

namespace cousin {

/// One thing that may have been wrong when somebody calibrated, and how much of it.
struct CalibrationCause {
  std::string name;  ///< "paper bent along its length"
  std::string unit;  ///< of the amounts: SI, "px", "deg" or "1"
  std::vector<double> amounts;
  std::function<void(double amount, CornerViewsConfig& views)> set;
  CalibrationSolver solver = CalibrationSolver::ceres;  ///< OpenCV's minimum, ten times as fast
};

/// Views as in the Strawberries paper: 30 of 5 x 8 corners, 25 mm apart, 0.3 to 0.6 m away, tilted
/// up to 20 degrees (the paper does not say how much), corners found to 0.1 px.
CornerViewsConfig strawberry_views();

/// The D457's colour camera as its maker's calibration has it.
Camera strawberry_camera();

/// What could have led the paper's calibration astray, alone and together.
const std::vector<CalibrationCause>& calibration_causes();

/// What one virtual copy of the paper's calibration comes to. NaN where nothing was solved.
struct CauseOutcome {
  double p1_error = 0;       ///< found less true
  double centre_px = 0;      ///< distance of the principal point from the true one
  double projection_px = 0;  ///< RMS over the image, no rotation counted
  double tutorial_px = 0, mean_distance_px = 0, rms_point_px = 0;
  bool is_refused = false;  ///< by our own check of the same corners: not determined
  /// p1 and the principal point as far off as the paper's are from any camera of that kind.
  bool is_like_paper() const { return std::abs(p1_error) >= 0.014 && centre_px >= 20; }
};

/// Calibrates `count` copies with five coefficients, as the paper does. The same on any number of
/// threads.
std::vector<CauseOutcome> run_cause(const CalibrationCause& cause, double amount, int count,
                                    const Rng& rng);

}  // namespace cousin
