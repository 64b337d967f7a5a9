#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "sim/types/mesh.h"

namespace cousin {

/// A convex body as half-spaces, for depths of points in it.
class ConvexBody {
 public:
  explicit ConvexBody(const Mesh& hull);
  /// Depth of a point of the body's frame, negative outside (then the distance to the farthest
  /// plane: at most the distance to the body). Stops early below `at_least_m`, giving some value
  /// below it.
  double depth_m(const Eigen::Vector3d& point_m,
                 double at_least_m = -std::numeric_limits<double>::infinity()) const;

 private:
  std::vector<Eigen::Vector3d> normals_;
  std::vector<double> offsets_m_;
};

}  // namespace cousin
