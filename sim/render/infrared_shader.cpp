#include "sim/render/infrared_shader.h"

#include <limits>

#include "sim/render/idle_lanes.h"
#include "sim/render/infrared_sky.h"
#include "sim/render/ray_limits.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {

InfraredHit resolve(const RayScene::Impl& impl, const std::vector<InfraredSurface>& surfaces,
                    const HitPacket& packet, int i, const Eigen::Vector3f& direction) {
  const SurfacePoint point =
      surface_point(impl, packet.hit.instID[0][i], packet.hit.geomID[i], packet.hit.primID[i],
                    packet.hit.u[i], packet.hit.v[i], direction);
  InfraredHit hit;
  hit.position_m = point.position_m;
  hit.normal = point.face_normal;
  hit.offset_m = point.offset_m;
  hit.surface = static_cast<int>(point.geometry);
  hit.share = surfaces[point.geometry].at(hit.position_m, point.part, point.has_print);
  return hit;
}

/// Radiance per irradiance of light that arrives from `to_light`, with its cosine.
float response(const InfraredHit& hit, const Eigen::Vector3f& to_light) {
  const float cosine = hit.normal.dot(to_light);
  return kInversePiF * (cosine > 0 ? hit.share.albedo * cosine : -hit.share.transmittance * cosine);
}

}  // namespace

InfraredShader::InfraredShader(const RayScene::Impl& impl, const InfraredLights& lights,
                               const std::vector<InfraredSurface>& surfaces)
    : impl_(impl),
      lights_(lights),
      surfaces_(surfaces),
      coherent_(make_context(RTC_INTERSECT_CONTEXT_FLAG_COHERENT)),
      incoherent_(make_context(RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT)) {}

void InfraredShader::operator()(InfraredSamples& s) {
  for (int i = 0; i < kLanes; ++i) {
    set_ray(camera_.ray, i, s.origin_m.x(), s.origin_m.y(), s.origin_m.z(), s.direction[i].x(),
            s.direction[i].y(), s.direction[i].z());
    camera_.hit.geomID[i] = kNoGeometry;
    s.steady[i] = s.projected[i] = s.ambient[i] = s.asked[i] = s.open[i] = 0;
    s.met[i] = false;
  }
  idle_lanes(s.mask, camera_.ray);
  rtcIntersect16(s.mask.lane, impl_.scene, &coherent_, &camera_);
  for (int i = 0; i < kLanes; ++i) {
    if (!s.mask.lane[i] || camera_.hit.geomID[i] == kNoGeometry) continue;
    s.met[i] = true;
    s.hit[i] = resolve(impl_, surfaces_, camera_, i, s.direction[i]);
  }
  for (const auto& projector : lights_.projectors) add_projector(s, projector);
  for (const auto& sun : lights_.suns) add_sun(s, sun);
  for (const auto& lamp : lights_.lamps) add_lamp(s, lamp);
  if (lights_.ambient_at(1) > 0 || lights_.ambient_at(-1) > 0) add_sky(s);
}

/// What an open sky would give, and one shadow ray along a direction drawn as the cosine. What
/// lies below the horizon stands for light that the ground throws back: nothing hides it.
void InfraredShader::add_sky(InfraredSamples& s) {
  for (int i = 0; i < kLanes; ++i) {
    mask_.lane[i] = 0;
    if (!s.met[i]) continue;
    const InfraredHit& hit = s.hit[i];
    const float above = lights_.ambient_at(hit.normal.z());
    const float below = lights_.ambient_at(-hit.normal.z());
    const float front = hit.share.albedo * above, back = hit.share.transmittance * below;
    s.ambient[i] = kInversePiF * (front + back);
    if (!(front + back > 0)) continue;
    Eigen::Vector2f u = s.sky[i];
    const float share = front / (front + back);
    const bool is_front = u.x() < share;
    u.x() = is_front ? u.x() / share : (u.x() - share) / (1 - share);
    const Eigen::Vector3f d =
        cosine_direction(is_front ? hit.normal : Eigen::Vector3f(-hit.normal), u);
    const float weight = static_cast<float>(lights_.dome.radiance(static_cast<double>(d.z()))) /
                         (is_front ? above : below);
    s.asked[i] = weight;
    if (d.z() < 0) {
      s.open[i] = weight;
    } else {
      aim(hit, i, d, std::numeric_limits<float>::infinity(), weight);
    }
  }
  add_unblocked(incoherent_, s.open);
}

void InfraredShader::add_lamp(InfraredSamples& s, const InfraredLights::LampFace& lamp) {
  for (int i = 0; i < kLanes; ++i) {
    mask_.lane[i] = 0;
    if (!s.met[i]) continue;
    const InfraredHit& hit = s.hit[i];
    const Eigen::Vector3f way = lamp.origin_m - hit.position_m;
    const float squared = way.squaredNorm();
    const Eigen::Vector3f d = way / std::sqrt(squared);
    const float facing = -lamp.normal.dot(d);
    if (!(facing > 0)) continue;
    const Eigen::Vector3f to =
        way + (2 * s.lamp[i].x() - 1) * lamp.axis_u_m + (2 * s.lamp[i].y() - 1) * lamp.axis_v_m;
    const float distance_m = to.norm();
    if (!(distance_m > 0)) continue;
    aim(hit, i, to / distance_m, distance_m * (1 - 1e-5F),
        response(hit, d) * lamp.intensity * facing / squared);
  }
  add_unblocked(coherent_, s.steady);
}

/// Starts a shadow ray of lane i towards a light that would give it `light`.
void InfraredShader::aim(const InfraredHit& hit, int i, const Eigen::Vector3f& d, float far_m,
                         float light) {
  mask_.lane[i] = 0;
  if (!(light > 0)) return;
  const Eigen::Vector3f o = offset_origin(hit.position_m, hit.normal, hit.offset_m, d);
  set_ray(shadow_, i, o.x(), o.y(), o.z(), d.x(), d.y(), d.z(), far_m);
  mask_.lane[i] = -1;
  light_[i] = light;
}

void InfraredShader::add_unblocked(RTCIntersectContext& context, float* radiance) {
  idle_lanes(mask_, shadow_);
  find_occluded(mask_, impl_.scene, context, shadow_);
  for (int i = 0; i < kLanes; ++i) {
    if (mask_.lane[i] && shadow_.tfar[i] >= 0) radiance[i] += light_[i];
  }
}

void InfraredShader::add_projector(InfraredSamples& s, const InfraredProjector& projector) {
  for (int i = 0; i < kLanes; ++i) {
    mask_.lane[i] = 0;
    if (!s.met[i]) continue;
    const Eigen::Vector3f way = projector.origin_m - s.hit[i].position_m;
    const float distance_m = way.norm();
    if (!(distance_m > 0)) continue;
    const Eigen::Vector3f d = way / distance_m;
    const float light = response(s.hit[i], d) * projector.towards(-way);
    aim(s.hit[i], i, d, distance_m, light / (distance_m * distance_m));
  }
  add_unblocked(coherent_, s.projected);
}

void InfraredShader::add_sun(InfraredSamples& s, const InfraredLights::Sun& sun) {
  for (int i = 0; i < kLanes; ++i) {
    mask_.lane[i] = 0;
    if (!s.met[i]) continue;
    aim(s.hit[i], i, sun.to_sun, std::numeric_limits<float>::infinity(),
        response(s.hit[i], sun.to_sun) * sun.irradiance);
  }
  add_unblocked(coherent_, s.steady);
}

}  // namespace cousin
