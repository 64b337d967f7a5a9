#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/types/rng.h"

namespace cousin {

/// Another family of shapes: radius 1 + sum of real spherical harmonics of degrees 2..`degrees`,
/// coefficients normal with standard deviation `strength` / l^2, at each of `directions` (unit).
/// Nothing of any species' own outlines is in it. The least radius is 0.3.
std::vector<double> harmonic_radii(const std::vector<Eigen::Vector3d>& directions, int degrees,
                                   double strength, Rng rng);

}  // namespace cousin
