#pragma once

#include <embree3/rtcore.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "sim/render/path_scene.h"
#include "sim/render/ray_packet.h"

namespace cousin {

/// Sheets nearer to each other than rays start off a surface. Private to sim/render.
///
/// A ray that leaves a surface starts off it on the side it goes to, and would miss what lies
/// between. One that goes through starts on the side it came from instead, and its own sheet is
/// skipped there; one that goes back while the surface before touches this one starts on the far
/// side, so that it meets that surface. So of two sheets that touch each is met once on every way;
/// of a pile of more, some may be met again or left out.

/// A triangle as Embree names it.
struct Sheet {
  unsigned int instance = RTC_INVALID_GEOMETRY_ID;
  unsigned int geometry = RTC_INVALID_GEOMETRY_ID;
  unsigned int triangle = 0;
  bool exists() const { return geometry != RTC_INVALID_GEOMETRY_ID; }
};

/// Sheets that a ray does not meet within `reach_m` of its start.
struct PathSkips {
  Sheet own, before;
  float reach_m = 0;
  bool exist() const { return own.exists(); }
};

/// How a ray leaves a surface.
struct PathStart {
  Eigen::Vector3f origin_m;
  PathSkips skips;
  float touch_m = 0;  ///< what it meets nearer than this touches the surface it left
};

/// Off the surface on the side it goes to.
inline PathStart plain_start(const PathHit& hit, const Eigen::Vector3f& direction) {
  return {offset_origin(hit.position_m, hit.face_normal, hit.offset_m, direction), {}, 0};
}

/// @param before  the surface that the path left before if it touches this one.
inline PathStart start_from(const PathHit& hit, const Sheet& own, const Sheet& before,
                            const Eigen::Vector3f& direction) {
  const float cosine = hit.face_normal.dot(direction);
  const bool goes_through = cosine < 0;
  const bool touches = before.exists();
  PathStart start;
  start.touch_m = 4 * hit.offset_m / std::max(std::abs(cosine), 1e-3F);
  if (!goes_through && !touches) {
    start.origin_m = hit.position_m + hit.offset_m * hit.face_normal;
    return start;
  }
  const float side = goes_through ? hit.offset_m : -hit.offset_m;
  start.origin_m = hit.position_m + side * hit.face_normal;
  start.skips.own = own;
  if (goes_through) start.skips.before = before;
  start.skips.reach_m = start.touch_m;
  return start;
}

/// A ray on its own.
inline RTCRay single_ray(const Eigen::Vector3f& origin_m, const Eigen::Vector3f& direction,
                         float far_m, float time) {
  RTCRay ray;
  ray.org_x = origin_m.x();
  ray.org_y = origin_m.y();
  ray.org_z = origin_m.z();
  ray.tnear = 0;
  ray.dir_x = direction.x();
  ray.dir_y = direction.y();
  ray.dir_z = direction.z();
  ray.time = time;
  ray.tfar = far_m;
  ray.mask = 0xFFFFFFFFU;
  ray.id = 0;
  ray.flags = 0;
  return ray;
}

/// Embree's context with what each lane (a ray's `id`) skips.
struct SkipContext {
  RTCIntersectContext context;
  const RayScene::Impl* rays = nullptr;
  std::array<const PathSkips*, kLanes> lanes{};
  const std::vector<PathInstance>* water = nullptr;  ///< whose clear bodies the lanes below skip
  std::array<bool, kLanes> passes_water{};
  std::array<bool, kLanes> met_water{};  ///< one of those, at any distance
};
/// A context that skips nothing yet; `use_skips` makes it look at `lanes`.
SkipContext make_skip_context(const RayScene::Impl& rays, RTCIntersectContextFlags flags);
void use_skips(SkipContext& context, bool used);

}  // namespace cousin
