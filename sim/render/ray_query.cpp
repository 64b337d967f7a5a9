#include "sim/render/ray_query.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <limits>

#include "sim/render/idle_lanes.h"
#include "sim/render/ray_scene_impl.h"

namespace cousin {
namespace {

Eigen::Vector3d world_normal(const RayScene::Impl& impl, const RayAnswer& answer) {
  const RayGeometry& g = impl.geometries[answer.geometry];
  const TrianglePlane plane = triangle_plane(impl.mesh_of(g), answer.triangle);
  const Eigen::Vector3d normal(plane.normal[0], plane.normal[1], plane.normal[2]);
  if (!g.is_instanced) return normal;
  return mesh_pose(impl, g, answer.time).rotation * normal;
}

RayAnswer cast(const RayScene::Impl& impl, const Eigen::Vector3f& o,
               const Eigen::Vector3d& direction, float time) {
  const FlushDenormals flush;
  RTCIntersectContext context = make_context(RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT);
  const Eigen::Vector3f d = direction.cast<float>();
  RTCRayHit ray{};
  ray.ray.org_x = o.x();
  ray.ray.org_y = o.y();
  ray.ray.org_z = o.z();
  ray.ray.dir_x = d.x();
  ray.ray.dir_y = d.y();
  ray.ray.dir_z = d.z();
  ray.ray.time = time;
  ray.ray.tfar = std::numeric_limits<float>::infinity();
  ray.ray.mask = 0xFFFFFFFFU;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(impl.scene, &context, &ray);
  RayAnswer answer;
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return answer;
  answer.hit = true;
  answer.time = time;
  answer.geometry = geometry_index(ray.hit.instID[0], ray.hit.geomID);
  answer.instance = impl.geometries[answer.geometry].id;
  answer.triangle = ray.hit.primID;
  answer.u = ray.hit.u;
  answer.v = ray.hit.v;
  answer.distance_m = static_cast<double>(ray.ray.tfar);
  const Eigen::Vector3d normal = world_normal(impl, answer);
  answer.is_back = normal.dot(direction) > 0;
  answer.normal = answer.is_back ? Eigen::Vector3d(-normal) : normal;
  return answer;
}

}  // namespace

RayAnswer cast_ray(const RayScene& rays, const Eigen::Vector3d& origin_in_world_m,
                   const Eigen::Vector3d& direction, double time_s) {
  return cast(rays.impl(), (origin_in_world_m - rays.impl().centre_m).cast<float>(), direction,
              ray_time(rays.impl(), time_s));
}

RayAnswer cast_from(const RayScene& rays, const RayAnswer& hit, const Eigen::Vector3d& direction) {
  const bool is_instanced = rays.impl().geometries[hit.geometry].is_instanced;
  const SurfacePoint point =
      surface_point(rays.impl(), is_instanced ? hit.geometry : RTC_INVALID_GEOMETRY_ID,
                    is_instanced ? 0 : hit.geometry, hit.triangle, hit.u, hit.v,
                    direction.cast<float>(), hit.time);
  return cast(rays.impl(),
              offset_origin(point.position_m, hit.normal.cast<float>(), point.offset_m,
                            direction.cast<float>()),
              direction, hit.time);
}

std::int64_t cast_packets(const RayScene& rays, const PreparedRays& prepared) {
  const RTCScene scene = rays.impl().scene;
  return tbb::parallel_reduce(
      tbb::blocked_range<int>(0, prepared.height, 8), std::int64_t{0},
      [&](const tbb::blocked_range<int>& range, std::int64_t hits) {
        const FlushDenormals flush;
        RTCIntersectContext context = make_context(RTC_INTERSECT_CONTEXT_FLAG_COHERENT);
        HitPacket packet;
        LaneMask mask;
        for (int y = range.begin(); y < range.end(); ++y) {
          const Eigen::Vector3f o =
              prepared.rows[static_cast<std::size_t>(y)].origin_m.cast<float>();
          const float time = prepared.rows[static_cast<std::size_t>(y)].time;
          const std::size_t row =
              static_cast<std::size_t>(y) * static_cast<std::size_t>(prepared.stride);
          for (int x = 0; x < prepared.width; x += kLanes) {
            load_packet(prepared, row + static_cast<std::size_t>(x), o, time, packet, mask);
            idle_lanes(mask, packet.ray);
            rtcIntersect16(mask.lane, scene, &context, &packet);
            for (int i = 0; i < kLanes; ++i)
              hits += packet.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID ? 1 : 0;
          }
        }
        return hits;
      },
      std::plus<>());
}

}  // namespace cousin
