#include "sim/physics/penetration.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace cousin {

ConvexBody::ConvexBody(const Mesh& hull) {
  for (const auto& t : hull.triangles) {
    const Eigen::Vector3d& p = hull.vertices_m[t[0]];
    const Eigen::Vector3d n = (hull.vertices_m[t[1]] - p).cross(hull.vertices_m[t[2]] - p);
    if (n.norm() < 1e-18) continue;  // m^2: a needle has no side
    normals_.push_back(n.normalized());
    offsets_m_.push_back(normals_.back().dot(p));
  }
}

double ConvexBody::depth_m(const Eigen::Vector3d& point_m, double at_least_m) const {
  double depth = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < normals_.size() && depth >= at_least_m; ++k)
    depth = std::min(depth, offsets_m_[k] - normals_[k].dot(point_m));
  return depth;
}

}  // namespace cousin
