#include "sim/render/ray_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace cousin {
namespace {

/// Whether some directed edge lacks its opposite.
bool has_boundary(const Mesh& mesh) {
  // Both ends and the direction in one number; sorted, opposite edges stand together.
  std::vector<std::uint64_t> edges;
  edges.reserve(mesh.triangles.size() * 3);
  for (const auto& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t a = t[k], b = t[(k + 1) % 3];
      edges.push_back(std::min(a, b) << 33 | std::max(a, b) << 1 | (a < b ? 1U : 0U));
    }
  }
  std::sort(edges.begin(), edges.end());
  for (std::size_t i = 0; i < edges.size();) {
    const std::uint64_t edge = edges[i] >> 1;
    int balance = 0;
    for (; i < edges.size() && edges[i] >> 1 == edge; ++i) balance += (edges[i] & 1U) ? 1 : -1;
    if (balance != 0) return true;
  }
  return false;
}

/// The printed face: all three corners within `bend_m` of z = 0 of the object, facing +z.
bool on_printed_face(const Mesh& mesh, const std::array<std::uint32_t, 3>& t, double bend_m) {
  for (const std::uint32_t v : t) {
    if (std::abs(mesh.vertices_m[v].z()) > bend_m) return false;
  }
  const Eigen::Vector3d a = mesh.vertices_m[t[0]];
  return (mesh.vertices_m[t[1]] - a).cross(mesh.vertices_m[t[2]] - a).z() > 0;
}

TrianglePlane make_plane(const std::array<Eigen::Vector3d, 3>& p,
                         const std::array<Eigen::Vector3f, 3>& f) {
  TrianglePlane plane{};
  const Eigen::Vector3d cross = (p[1] - p[0]).cross(p[2] - p[0]);
  const double length = cross.norm();
  const Eigen::Vector3d normal =
      length > 0 ? Eigen::Vector3d(cross / length) : Eigen::Vector3d::Zero();
  // The middle of the triangle: the rounding of the normal then acts over the shortest arm.
  const double distance = normal.dot((p[0] + p[1] + p[2]) / 3);
  float largest = 0, size = 0;
  for (int k = 0; k < 3; ++k) {
    plane.normal[k] = normal[k];
    plane.low[k] = std::min({f[0][k], f[1][k], f[2][k]});
    plane.high[k] = std::max({f[0][k], f[1][k], f[2][k]});
    largest = std::max({largest, std::abs(plane.low[k]), std::abs(plane.high[k])});
    size = std::max(size, plane.high[k] - plane.low[k]);
  }
  plane.distance = distance;
  plane.offset_m = kRoundUlps * largest + kTestUlps * size;
  return plane;
}

TrianglePlane plane_of(const RayMesh& mesh, const std::vector<Eigen::Vector3d>& exact_m,
                       std::size_t triangle) {
  const auto& t = mesh.triangles[triangle];
  TrianglePlane plane =
      make_plane({exact_m[t[0]], exact_m[t[1]], exact_m[t[2]]},
                 {mesh.vertices_m[t[0]], mesh.vertices_m[t[1]], mesh.vertices_m[t[2]]});
  if (!mesh.parts.empty()) plane.part = mesh.parts[triangle];
  if (!mesh.has_print.empty()) plane.has_print = mesh.has_print[triangle];
  return plane;
}

/// Fills the mesh's vertices; returns them before they were rounded.
std::vector<Eigen::Vector3d> place_vertices(const ObjectModel& model,
                                            const MeshPlacement& placement, RayMesh& mesh) {
  std::vector<Eigen::Vector3d> vertices(model.mesh.vertices_m.size());
  mesh.vertices_m.resize(vertices.size() + 1, Eigen::Vector3f::Zero());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Eigen::Vector3d& v = model.mesh.vertices_m[i];
    vertices[i] = placement.is_instanced ? Eigen::Vector3d(v - mesh.centre_in_object_m)
                                         : placement.world_from_object * v - placement.centre_m;
    // Embree multiplies three coordinates: a float ends at 3e38.
    constexpr double kLargest_m = 1e12;
    if (!(vertices[i].cwiseAbs().maxCoeff() <= kLargest_m)) {
      throw std::invalid_argument("model \"" + model.name + "\": vertex " + std::to_string(i) +
                                  " is farther than 1e12 m from the scene's centre");
    }
    mesh.vertices_m[i] = vertices[i].cast<float>();
  }
  return vertices;
}

}  // namespace

std::array<Eigen::Vector3d, 8> box_corners(const Mesh& mesh) {
  Eigen::Vector3d low = Eigen::Vector3d::Zero(), high = low;
  if (!mesh.vertices_m.empty()) low = high = mesh.vertices_m[0];
  for (const Eigen::Vector3d& v : mesh.vertices_m) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  std::array<Eigen::Vector3d, 8> corners;
  for (std::size_t k = 0; k < 8; ++k) {
    corners[k] = {(k & 1U) ? high.x() : low.x(), (k & 2U) ? high.y() : low.y(),
                  (k & 4U) ? high.z() : low.z()};
  }
  return corners;
}

RayMesh make_ray_mesh(const ObjectModel& model, const MeshPlacement& placement) {
  const std::array<Eigen::Vector3d, 8> box = box_corners(model.mesh);
  RayMesh mesh;
  mesh.is_open = has_boundary(model.mesh);
  mesh.triangles = model.mesh.triangles;
  if (placement.is_instanced) mesh.centre_in_object_m = 0.5 * (box[0] + box[7]);
  std::vector<Eigen::Vector3d> vertices = place_vertices(model, placement, mesh);
  mesh.parts = model.triangle_part;
  if (placement.has_print) {
    const double bend_m = placement.print_bend_m + 1e-9 * (box[7] - box[0]).norm();
    mesh.has_print.resize(mesh.triangles.size());
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
      mesh.has_print[i] = on_printed_face(model.mesh, mesh.triangles[i], bend_m) ? 1 : 0;
  }
  if (!placement.keeps_planes) {
    mesh.exact_m = std::move(vertices);
    return mesh;
  }
  mesh.planes.resize(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    mesh.planes[i] = plane_of(mesh, vertices, i);
  mesh.parts = {};
  mesh.has_print = {};
  return mesh;
}

TrianglePlane made_plane(const RayMesh& mesh, std::uint32_t triangle) {
  return plane_of(mesh, mesh.exact_m, triangle);
}

}  // namespace cousin
