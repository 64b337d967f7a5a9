#pragma once

#include "calibration/bundle/bundle_problem.h"

namespace cousin {

/// Measurements less unknowns: sightings in use, what is known of the points that they show, and
/// lenses, poses and those points.
int freedoms_of(const BundleProblem& problem);

/// Sum of squares under the loss, with those of what is known before, and that of sightings alone
/// without it.
struct BundleSquares {
  double softened = 0, plain = 0;
  int points = 0;
};
BundleSquares squares_of(const BundleProblem& problem);

/// Median of the residuals' lengths over sqrt(2 ln 2): the deviation of a coordinate, outliers or
/// not.
double robust_sigma(const BundleProblem& problem);

}  // namespace cousin
