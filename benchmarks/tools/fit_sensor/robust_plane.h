#pragma once

#include <Eigen/Core>
#include <span>

#include "sim/types/rng.h"

namespace cousin {

/// A sample of a plane in disparity: value = a + b x + c y.
struct PlaneSample {
  double x = 0, y = 0, value = 0;
};

/// Plane by least median of squares over random triples [Rousseeuw 1984], then by least squares of
/// what lies within `gate_px` or five robust standard deviations of it, whichever is more.
struct RobustPlane {
  Eigen::Vector3d coefficients = Eigen::Vector3d::Zero();  ///< a, b, c
  double gate_px = 0;                                      ///< beyond, samples are not the plane's
  bool found = false;                                      ///< at least 16 samples, not on one line
};
RobustPlane fit_robust_plane(std::span<const PlaneSample> samples, double gate_px, Rng rng);

}  // namespace cousin
