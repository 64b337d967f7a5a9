#pragma once

#include <Eigen/Core>
#include <vector>

#include "scenes/strawberries/truss.h"

namespace cousin {

/// Private to scenes/strawberries: the raised bed as a ridge with a level top, round shoulders and
/// sloping sides.

/// Its section in x and z, from the path's foot over both shoulders to the far foot.
struct BedOutline {
  std::vector<Eigen::Vector2d> points_m, normals;  ///< outward, unit
  std::vector<int> face;                           ///< 0 a side, 1 a shoulder, 2 the top
};
/// @param cell_m  between points
BedOutline bed_outline(const TrussShape& shape, double cell_m);

/// The same as boxes whose round edges are the shoulders: top, near side, far side.
std::vector<BendingObstacle> bed_obstacles(const TrussShape& shape);

/// Depth of a point in the deepest of some obstacles; negative outside all: the least distance.
double depth_m(const std::vector<BendingObstacle>& obstacles, const Eigen::Vector3d& in_world_m);

}  // namespace cousin
