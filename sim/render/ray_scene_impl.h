#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "sim/render/ray_packet.h"
#include "sim/render/ray_scene.h"
#include "sim/render/truth_pass.h"

namespace cousin {

/// What a hit needs of its triangle, in one cache line.
struct alignas(64) TrianglePlane {
  double normal[3];       ///< unit, counter-clockwise side; zero for a triangle without area
  double distance;        ///< normal . x on the plane, x from RayScene's centre
  float low[3], high[3];  ///< bounds of the float vertices
  float offset_m;         ///< how far along the normal a ray must start to clear rounding
  std::uint16_t part;
  std::uint16_t has_print;  ///< the face z = 0 of an object whose material has a print
};
static_assert(sizeof(TrianglePlane) == 64);

/// One instance as Embree sees it: vertices in the world less RayScene's centre.
struct RayGeometry {
  int instance_index = 0;  ///< into Scene::instances
  int id = 0;              ///< Instance::id
  bool is_specimen = false;
  bool is_open = false;                     ///< has boundary edges, so that rays may meet its back
  std::vector<Eigen::Vector3f> vertices_m;  ///< one more than the mesh has: Embree reads 16 bytes
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<TrianglePlane> planes;
  std::array<Eigen::Vector3d, 8> box_corners_m;  ///< of its bounds in object axes, in the world
  RTCScene alone = nullptr;                      ///< specimens: this geometry and nothing else
};

struct RayScene::Impl {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  /// Subtracted from the world before anything becomes float, so that a distant scene keeps its
  /// precision.
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  double time_s = 0;
  std::vector<RayGeometry> geometries;  ///< index = Embree's geomID = index into Scene::instances

  Impl() = default;
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl();
};

/// Rounding of a hit is a few ulps of the largest coordinate involved: vertices and hit are within
/// the triangle's coordinates, and Embree's edge tests lose a few more. Rays start this far off the
/// surface.
inline constexpr float kOffsetUlps = 32 * 0x1p-24F;

/// Point of a triangle by the barycentric weights of its second and third vertex.
template <class Vector>
Vector interpolate(const Vector& a, const Vector& b, const Vector& c, float u, float v) {
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
                        const Eigen::Vector3f& origin_m, HitPacket& packet, LaneMask& mask) {
  for (int i = 0; i < kLanes; ++i) {
    const std::size_t j = first + static_cast<std::size_t>(i);
    set_ray(packet.ray, i, origin_m.x(), origin_m.y(), origin_m.z(), rays.x[j], rays.y[j],
            rays.z[j]);
    packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    mask.lane[i] = rays.x[j] != 0 || rays.y[j] != 0 || rays.z[j] != 0 ? -1 : 0;
  }
}

}  // namespace cousin
