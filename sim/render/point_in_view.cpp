#include "sim/render/point_in_view.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/render/ray_scene_impl.h"

namespace cousin {
namespace {

/// The point as the camera sees it at the time of one row.
PointInView at_row(const TrueView& view, const Instance& instance,
                   const Eigen::Vector3d& in_object_m, double row, Eigen::Vector3d& in_camera_m) {
  const double y = std::clamp(row, 0.0, static_cast<double>(view.camera.height_px - 1));
  PointInView point;
  point.time_s = time_at_row(view, y);
  point.in_world_m = world_from_object(instance, point.time_s) * in_object_m;
  const Pose camera_from_world = pose_at_row(view, y);
  point.centre_in_world_m = centre_in_world_m(camera_from_world);
  in_camera_m = camera_from_world * point.in_world_m;
  point.depth_m = in_camera_m.z();
  return point;
}

/// Point of a triangle that is nearest to p [Ericson, Real-Time Collision Detection, 5.1.5].
Eigen::Vector3d nearest_on_triangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                    const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const Eigen::Vector3d ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp),
               d6 = ac.dot(cp);
  if (d1 <= 0 && d2 <= 0) return a;
  if (d3 >= 0 && d4 <= d3) return b;
  if (d6 >= 0 && d5 <= d6) return c;
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
  if (va <= 0 && d4 >= d3 && d5 >= d6) return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  return a + (vb * ab + vc * ac) / (va + vb + vc);
}

struct NearestQuery {
  const RayMesh* mesh = nullptr;
  Eigen::Vector3d point_m;
  double distance_m = std::numeric_limits<double>::infinity();
};

bool shrink_to_triangle(RTCPointQueryFunctionArguments* arguments) {
  auto& query = *static_cast<NearestQuery*>(arguments->userPtr);
  const auto& t = query.mesh->triangles[arguments->primID];
  const auto corner = [&](std::size_t k) -> Eigen::Vector3d {
    return query.mesh->vertices_m[t[k]].cast<double>();
  };
  const double distance_m =
      (nearest_on_triangle(query.point_m, corner(0), corner(1), corner(2)) - query.point_m).norm();
  if (!(distance_m < query.distance_m)) return false;
  query.distance_m = distance_m;
  arguments->query->radius = static_cast<float>(distance_m * (1 + 1e-6));
  return true;
}

}  // namespace

std::optional<PointInView> image_of(const TrueView& view, const Instance& instance,
                                    const Eigen::Vector3d& in_object_m) {
  double row = 0.5 * (view.camera.height_px - 1);
  constexpr int kSteps = 50;
  for (int step = 0; step < kSteps; ++step) {
    Eigen::Vector3d in_camera_m;
    PointInView point = at_row(view, instance, in_object_m, row, in_camera_m);
    const auto pixel = project(view.camera, in_camera_m);
    if (!pixel) return std::nullopt;
    point.pixel_px = *pixel;
    constexpr double kTolerance_px = 1e-6;
    const bool moves =
        (view.readout_s > 0 && !instance.motion.empty()) ||
        view.camera_from_world.rotation.coeffs() != view.camera_from_world_end.rotation.coeffs() ||
        view.camera_from_world.translation_m != view.camera_from_world_end.translation_m;
    if (!moves || std::abs(pixel->y() - row) < kTolerance_px) return point;
    row = pixel->y();
  }
  return std::nullopt;
}

bool is_inside(const Camera& camera, const Eigen::Vector2d& pixel_px) {
  return pixel_px.x() >= -0.5 && pixel_px.y() >= -0.5 && pixel_px.x() < camera.width_px - 0.5 &&
         pixel_px.y() < camera.height_px - 0.5;
}

bool is_in_sight(const RayScene& rays, const PointInView& point, std::size_t own, double skin_m) {
  const RayScene::Impl& impl = rays.impl();
  const FlushDenormals flush;
  const Eigen::Vector3d o = point.centre_in_world_m - impl.centre_m;
  const Eigen::Vector3d p = point.in_world_m - impl.centre_m;
  const double distance_m = (p - o).norm();
  constexpr double kRayUlps = 32 * 0x1p-24;  // origin, direction and hit in float
  const double rounding_m = 2e-6 * distance_m + kRayUlps * (o.lpNorm<1>() + p.lpNorm<1>());
  const Eigen::Vector3d d = (p - o) / distance_m;
  const float time = ray_time(impl, point.time_s);
  RTCIntersectContext context = make_context(RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT);
  float tnear = 0;
  for (;;) {
    RTCRayHit ray{};
    ray.ray.org_x = static_cast<float>(o.x());
    ray.ray.org_y = static_cast<float>(o.y());
    ray.ray.org_z = static_cast<float>(o.z());
    ray.ray.dir_x = static_cast<float>(d.x());
    ray.ray.dir_y = static_cast<float>(d.y());
    ray.ray.dir_z = static_cast<float>(d.z());
    ray.ray.time = time;
    ray.ray.tnear = tnear;
    ray.ray.tfar = static_cast<float>(distance_m - rounding_m);
    ray.ray.mask = 0xFFFFFFFFU;
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    if (!(ray.ray.tnear < ray.ray.tfar)) return true;
    rtcIntersect1(impl.scene, &context, &ray);
    if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return true;
    const std::uint32_t geometry = geometry_index(ray.hit.instID[0], ray.hit.geomID);
    const RayGeometry& g = impl.geometries[geometry];
    const TrianglePlane plane = triangle_plane(impl.mesh_of(g), ray.hit.primID);
    const Eigen::Vector3d normal(plane.normal[0], plane.normal[1], plane.normal[2]);
    const Eigen::Vector3d in_plane_axes =
        g.is_instanced ? inverse(mesh_pose(impl, g, time)) * p : p;
    const bool on_plane = std::abs(normal.dot(in_plane_axes) - plane.distance) <= rounding_m;
    // A plant's node lies in its stem, whichever of its organs carries it.
    const bool on_skin = g.id == impl.geometries[own].id &&
                         distance_m - static_cast<double>(ray.ray.tfar) <= skin_m + rounding_m;
    if (!on_plane && !on_skin) return false;
    tnear = beyond(ray.ray.tfar);
  }
}

double distance_to_surface_m(const RayScene& rays, std::size_t own,
                             const Eigen::Vector3d& in_object_m) {
  const RayScene::Impl& impl = rays.impl();
  const RayGeometry& g = impl.geometries[own];
  const RayMesh& mesh = impl.mesh_of(g);
  if (!mesh.alone) return 0;
  NearestQuery nearest;
  nearest.mesh = &mesh;
  nearest.point_m = g.is_instanced ? Eigen::Vector3d(in_object_m - mesh.centre_in_object_m)
                                   : object_pose(g, 0) * in_object_m;
  RTCPointQuery query{};
  query.x = static_cast<float>(nearest.point_m.x());
  query.y = static_cast<float>(nearest.point_m.y());
  query.z = static_cast<float>(nearest.point_m.z());
  query.radius = std::numeric_limits<float>::infinity();
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(mesh.alone, &query, &context, shrink_to_triangle, &nearest);
  return std::isfinite(nearest.distance_m) ? nearest.distance_m : 0;
}

}  // namespace cousin
