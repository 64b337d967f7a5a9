#include "perception/silhouette/apparent_contour.h"

#include <array>
#include <cmath>

namespace cousin {

std::vector<Eigen::Vector3d> vertex_normals(const Mesh& mesh) {
  std::vector<Eigen::Vector3d> normals(mesh.vertices_m.size(), Eigen::Vector3d::Zero());
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3d& origin = mesh.vertices_m[a];
    const Eigen::Vector3d area = (mesh.vertices_m[b] - origin).cross(mesh.vertices_m[c] - origin);
    normals[a] += area;
    normals[b] += area;
    normals[c] += area;
  }
  for (Eigen::Vector3d& normal : normals) normal.normalize();
  return normals;
}

std::vector<ContourSegment> apparent_contour(const SampledSurface& surface,
                                             const std::vector<Eigen::Vector3d>& directions,
                                             const FramePose& view) {
  const Eigen::Vector3d eye = centre_in_world_m(view.camera_from_world);
  const auto& vertices = surface.mesh.vertices_m;
  std::vector<double> facing(vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    facing[i] = surface.normals[i].dot(eye - vertices[i]);
  }

  struct End {
    Eigen::Vector2d pixel_px, outward;
    Eigen::Vector3d u;
  };
  const auto end_on_edge = [&](std::uint32_t i, std::uint32_t j) -> std::optional<End> {
    const double s = facing[i] / (facing[i] - facing[j]);
    const Eigen::Vector3d point = (1 - s) * vertices[i] + s * vertices[j];
    const Eigen::Vector3d normal = (1 - s) * surface.normals[i] + s * surface.normals[j];
    const auto projection = project_with_jacobian(view.camera, view.camera_from_world * point);
    if (!projection) return std::nullopt;
    return End{projection->pixel_px,
               projection->d_point * (view.camera_from_world.rotation * normal),
               (1 - s) * directions[i] + s * directions[j]};
  };

  std::vector<ContourSegment> contour;
  for (const auto& triangle : surface.mesh.triangles) {
    std::array<std::optional<End>, 2> ends;
    int count = 0;
    for (int k = 0; k < 3 && count < 2; ++k) {
      // Lower index first: both triangles of an edge get the same bits.
      const std::uint32_t a = triangle[static_cast<std::size_t>(k)];
      const std::uint32_t b = triangle[static_cast<std::size_t>((k + 1) % 3)];
      if ((facing[a] > 0) == (facing[b] > 0)) continue;
      ends[static_cast<std::size_t>(count++)] = a < b ? end_on_edge(a, b) : end_on_edge(b, a);
    }
    if (count < 2 || !ends[0] || !ends[1]) continue;
    const Eigen::Vector2d outward = (ends[0]->outward + ends[1]->outward).normalized();
    contour.push_back({ends[0]->pixel_px, ends[1]->pixel_px, outward, ends[0]->u, ends[1]->u});
  }
  return contour;
}

std::optional<ContourCrossing> cross_contour(const std::vector<ContourSegment>& contour,
                                             const Eigen::Vector2d& pixel_px,
                                             const Eigen::Vector2d& normal, double limit_px) {
  std::optional<ContourCrossing> best;
  const Eigen::Vector2d tangent(-normal.y(), normal.x());
  for (const ContourSegment& segment : contour) {
    const double begin = tangent.dot(segment.begin_px - pixel_px);
    const double end = tangent.dot(segment.end_px - pixel_px);
    if ((begin > 0) == (end > 0)) continue;
    if (segment.outward.dot(normal) < 0.5) continue;
    const double s = begin / (begin - end);
    const double t = normal.dot((1 - s) * segment.begin_px + s * segment.end_px - pixel_px);
    if (std::abs(t) > limit_px || (best && t <= best->t_px)) continue;
    best = {t, ((1 - s) * segment.begin_u + s * segment.end_u).normalized()};
  }
  return best;
}

}  // namespace cousin
