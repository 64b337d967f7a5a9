#pragma once

#include <Eigen/Core>

#include "sim/geometry/point_set.h"

namespace cousin::geometry {

/// Private to sim/geometry: search over rotations for the box of least volume around points that
/// span space. Columns of the result are the box's axes. `points` should have an extent near one.

/// Global: starts spread over all rotations on a subset of the points, the best of them refined on
/// all.
Eigen::Matrix3d search_box_axes(const PointSet& points, const Eigen::Matrix3d& guess);

/// Local: the minimum whose basin `axes` lies in, to a relative 1e-9 of the volume.
Eigen::Matrix3d refine_box_axes(const PointSet& points, const Eigen::Matrix3d& axes);

double box_volume(const PointSet& points, const Eigen::Matrix3d& axes);

}  // namespace cousin::geometry
