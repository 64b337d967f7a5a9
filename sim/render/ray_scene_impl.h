#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "sim/render/ray_packet.h"
#include "sim/render/ray_scene.h"
#include "sim/render/truth_pass.h"
#include "sim/types/pose.h"

namespace cousin {

/// What a hit needs of its triangle, in one cache line; in the axes of its RayMesh.
struct alignas(64) TrianglePlane {
  double normal[3];       ///< unit, counter-clockwise side; zero for a triangle without area
  double distance;        ///< normal . x on the plane
  float low[3], high[3];  ///< bounds of the float vertices
  float offset_m;         ///< how far along the normal a ray must start to clear rounding
  std::uint16_t part;
  std::uint16_t has_print;  ///< the face z = 0 of an object whose material has a print
};
static_assert(sizeof(TrianglePlane) == 64);

/// Triangles as Embree sees them. Either a model's, in its axes less `centre_in_object_m`, which
/// instances share; or one instance's, in the world less RayScene's centre.
struct RayMesh {
  bool is_open = false;                     ///< has boundary edges, so that rays may meet its back
  std::vector<Eigen::Vector3f> vertices_m;  ///< one more than the mesh has: Embree reads 16 bytes
  std::vector<std::array<std::uint32_t, 3>> triangles;
  /// One a triangle; empty in a scene of many triangles, whose planes are made at need from:
  std::vector<TrianglePlane> planes;
  std::vector<Eigen::Vector3d> exact_m;  ///< the vertices before they were rounded
  std::vector<std::uint16_t> parts;      ///< one a triangle, or empty: all 0
  std::vector<std::uint16_t> has_print;  ///< one a triangle, or empty: all 0
  Eigen::Vector3d centre_in_object_m = Eigen::Vector3d::Zero();
  RTCScene alone = nullptr;  ///< these triangles and nothing else: shared meshes and specimens
};

/// One instance: which triangles, and where they are.
struct RayGeometry {
  int instance_index = 0;    ///< into Scene::instances
  int id = 0;                ///< Instance::id; of an organ its specimen's
  bool is_specimen = false;  ///< or an organ of one
  /// Its mesh is in the model's axes: Embree reports it by instID. Else in the world, by geomID.
  bool is_instanced = false;
  bool has_print = false;  ///< its material has one
  std::uint32_t mesh = 0;  ///< into Impl::meshes
  /// World less RayScene's centre, from the object's axes; evenly over RayScene's span of time, the
  /// translation linear and the rotation by normalised linear steps between; one if it stands
  /// still.
  std::vector<Pose> steps;
  std::array<Eigen::Vector3d, 8> box_corners_in_object_m;  ///< of its bounds
};

struct RayScene::Impl {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  /// Subtracted from the world before anything becomes float, so that a distant scene keeps its
  /// precision.
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  TimeSpan span_s;
  std::vector<RayMesh> meshes;
  std::vector<RayGeometry> geometries;  ///< index = place in Scene::instances

  Impl() = default;
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl();

  const RayMesh& mesh_of(const RayGeometry& geometry) const { return meshes[geometry.mesh]; }
};

/// A triangle's plane, kept or made at need; the same numbers either way.
TrianglePlane made_plane(const RayMesh& mesh, std::uint32_t triangle);
inline TrianglePlane triangle_plane(const RayMesh& mesh, std::uint32_t triangle) {
  return mesh.planes.empty() ? made_plane(mesh, triangle) : mesh.planes[triangle];
}

/// Time of a ray as Embree takes it: 0 at the begin of RayScene's span, 1 at its end, held beyond.
float ray_time(const RayScene::Impl& impl, double time_s);

/// Where an object is at a ray's time: world less RayScene's centre from object.
Pose object_pose(const RayGeometry& geometry, float time);

/// Where the axes of an instanced geometry's RayMesh are at a ray's time: world less RayScene's
/// centre from mesh.
Pose mesh_pose(const RayScene::Impl& impl, const RayGeometry& geometry, float time);

/// Index into Impl::geometries of what Embree reports for a hit.
inline std::uint32_t geometry_index(unsigned int inst_id, unsigned int geom_id) {
  return inst_id == RTC_INVALID_GEOMETRY_ID ? geom_id : inst_id;
}

/// A point where a ray met a surface, for light: in float, world less RayScene's centre.
struct SurfacePoint {
  std::uint32_t geometry = 0;               ///< into Impl::geometries, and into Scene::instances
  std::uint32_t triangle = 0;               ///< of the model's mesh
  std::array<std::uint32_t, 3> vertices{};  ///< of that triangle, into the model's arrays
  float u = 0, v = 0;                       ///< barycentric weights of the second and third vertex
  Eigen::Vector3f position_m = Eigen::Vector3f::Zero();
  Eigen::Vector3f face_normal = Eigen::Vector3f::Zero();  ///< unit, towards where the ray came from
  float offset_m = 0;  ///< rays that leave start this far along the normal: see offset_origin
  std::uint16_t part = 0;
  bool is_back = false;    ///< met on the clockwise side
  bool has_print = false;  ///< on the face that carries the material's print
};

/// The one way to understand a hit of RayScene's Embree scene, flattened or instanced, still or
/// moving. Arguments are Embree's: hit.instID[0], hit.geomID, hit.primID, hit.u, hit.v, the ray's
/// direction in the world and its time. The object's axes there are object_pose(
/// impl.geometries[point.geometry], time).
SurfacePoint surface_point(const RayScene::Impl& impl, unsigned int inst_id, unsigned int geom_id,
                           unsigned int prim_id, float u, float v, const Eigen::Vector3f& direction,
                           float time = 0);

/// How far off a surface rays start, so that they neither meet it again nor skip another sheet near
/// it. The hit, made in double from the float vertices, rounds by half an ulp of its largest
/// coordinate; Embree's tests, relative to the ray's origin, lose some ulps of the triangle's size;
/// where a mesh is instanced, it takes the ray into the mesh's axes in float.
inline constexpr float kRoundUlps = 4 * 0x1p-24F;
inline constexpr float kTestUlps = 16 * 0x1p-24F;
inline constexpr float kInstanceUlps = 8 * 0x1p-24F;

/// Point of a triangle by the barycentric weights of its second and third vertex.
template <class Vector>
Vector interpolate(const Vector& a, const Vector& b, const Vector& c, typename Vector::Scalar u,
                   typename Vector::Scalar v) {
  return a * (1 - u - v) + b * u + c * v;
}

/// Where a ray that leaves a surface along `direction` starts: off the face by `offset_m` on that
/// side.
inline Eigen::Vector3f offset_origin(const Eigen::Vector3f& position_m,
                                     const Eigen::Vector3f& normal, float offset_m,
                                     const Eigen::Vector3f& direction) {
  return position_m + (normal.dot(direction) >= 0 ? offset_m : -offset_m) * normal;
}

/// Fills a packet with prepared rays from one origin; lanes without a direction are masked.
inline void load_packet(const PreparedRays& rays, std::size_t first,
                        const Eigen::Vector3f& origin_m, float time, HitPacket& packet,
                        LaneMask& mask) {
  for (int i = 0; i < kLanes; ++i) {
    const std::size_t j = first + static_cast<std::size_t>(i);
    set_ray(packet.ray, i, origin_m.x(), origin_m.y(), origin_m.z(), rays.x[j], rays.y[j],
            rays.z[j]);
    packet.ray.time[i] = time;
    packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    mask.lane[i] = rays.x[j] != 0 || rays.y[j] != 0 || rays.z[j] != 0 ? -1 : 0;
  }
}

}  // namespace cousin
