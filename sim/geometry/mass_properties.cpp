#include <Eigen/Geometry>
#include <stdexcept>
#include <string>

#include "sim/geometry/measure.h"

namespace cousin {

MassProperties mass_properties(const Mesh& mesh) {
  if (mesh.triangles.empty())
    throw std::invalid_argument("mass properties of a mesh without triangles");
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < mesh.vertices_m.size(); ++i) {
    if (!mesh.vertices_m[i].allFinite()) {
      throw std::invalid_argument("mass properties: vertex " + std::to_string(i) +
                                  " is not finite");
    }
    origin += mesh.vertices_m[i] / static_cast<double>(mesh.vertices_m.size());
  }

  // Sums over the tetrahedra (origin, a, b, c); `second` is the integral of x x^T.
  MassProperties out;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& triangle = mesh.triangles[t];
    for (const std::uint32_t index : triangle) {
      if (index >= mesh.vertices_m.size()) {
        throw std::invalid_argument("mass properties: triangle " + std::to_string(t) +
                                    " names vertex " + std::to_string(index) + " of " +
                                    std::to_string(mesh.vertices_m.size()));
      }
    }
    const Eigen::Vector3d a = mesh.vertices_m[triangle[0]] - origin;
    const Eigen::Vector3d b = mesh.vertices_m[triangle[1]] - origin;
    const Eigen::Vector3d c = mesh.vertices_m[triangle[2]] - origin;
    out.area_m2 += 0.5 * (b - a).cross(c - a).norm();
    const double six_volumes = a.dot(b.cross(c));
    const Eigen::Vector3d sum = a + b + c;
    out.volume_m3 += six_volumes / 6;
    first += six_volumes / 24 * sum;
    second += six_volumes / 120 *
              (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  if (out.volume_m3 ==
      0) {  // a flat or cancelling mesh has no centroid of volume; its vertices' mean stands in
    out.centroid_m = origin;
    return out;
  }
  const Eigen::Vector3d centroid = first / out.volume_m3;
  const Eigen::Matrix3d central = second - out.volume_m3 * centroid * centroid.transpose();
  out.inertia_m5 = central.trace() * Eigen::Matrix3d::Identity() - central;
  out.centroid_m = origin + centroid;
  return out;
}

}  // namespace cousin
