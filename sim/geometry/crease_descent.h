#pragma once

#include <Eigen/Core>

#include "sim/geometry/point_set.h"

namespace cousin::geometry {

/// Private to sim/geometry. Follows the creases of the volume, where an edge of the hull is flush
/// with a side, to the minimum near `axes`: three creases meet in a point, two in a line along
/// which the volume is smooth. For points of unit extent, and `axes` already within about 1e-3 rad;
/// converges quadratically, where a simplex search stalls.
Eigen::Matrix3d descend_creases(const PointSet& points, const Eigen::Matrix3d& axes);

}  // namespace cousin::geometry
