#include "sim/geometry/smooth_normals.h"

#include <Eigen/Geometry>

namespace cousin {

std::vector<Eigen::Vector3f> smooth_normals(const Mesh& mesh) {
  std::vector<Eigen::Vector3d> sums(mesh.vertices_m.size(), Eigen::Vector3d::Zero());
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d& a = mesh.vertices_m[t[0]];
    const Eigen::Vector3d normal = (mesh.vertices_m[t[1]] - a).cross(mesh.vertices_m[t[2]] - a);
    for (const std::uint32_t i : t) sums[i] += normal;
  }
  std::vector<Eigen::Vector3f> normals;
  normals.reserve(sums.size());
  for (const Eigen::Vector3d& sum : sums) {
    const double length = sum.norm();
    normals.emplace_back(length > 0 ? Eigen::Vector3f((sum / length).cast<float>())
                                    : Eigen::Vector3f::UnitZ());
  }
  return normals;
}

}  // namespace cousin
