#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/physics/bending_plant.h"

namespace cousin {

/// Private to physics.

/// Where what grows from a root can come to, however it bends.
struct Reach {
  Eigen::Vector3d centre_m;
  double radius_m = 0;
};
/// One for each root. @param plant  that validate() takes
std::vector<Reach> reaches_of(const BendingPlant& plant);

/// Whether anything can come to the box between two corners in the frame of an obstacle; what
/// begins inside the obstacle may touch it from within.
bool is_reached(const std::vector<Reach>& reaches, const BendingObstacle& obstacle,
                const Eigen::Vector3d& low_m, const Eigen::Vector3d& high_m);

}  // namespace cousin
