#include <algorithm>

#include "sim/render/idle_lanes.h"
#include "sim/render/path_batch.h"

namespace cousin {

using Eigen::Vector3f;

void PathBatch::trace_shadows(bool is_coherent) {
  rays_ += shadows_.size();
  if (is_coherent) {
    trace_shadow_packets();
  } else {
    trace_shadow_singles();
  }
}

void PathBatch::trace_shadow_packets() {
  SkipContext context = make_skip_context(*scene_.rays, RTC_INTERSECT_CONTEXT_FLAG_COHERENT);
  context.water = &scene_.instances;
  ShadowPacket packet;
  for (std::size_t first = 0; first < shadows_.size(); first += kLanes) {
    LaneMask mask;
    bool any_skips = false;
    for (int i = 0; i < kLanes; ++i) {
      const std::size_t k = std::min(first + static_cast<std::size_t>(i), shadows_.size() - 1);
      const Shadow& s = shadows_[k];
      set_ray(packet, i, s.origin_m.x(), s.origin_m.y(), s.origin_m.z(), s.direction.x(),
              s.direction.y(), s.direction.z(), s.far_m);
      packet.time[i] = s.time;
      packet.id[i] = static_cast<unsigned int>(i);
      context.lanes[static_cast<std::size_t>(i)] = s.skips.exist() ? &s.skips : nullptr;
      context.passes_water[static_cast<std::size_t>(i)] = s.passes_water;
      context.met_water[static_cast<std::size_t>(i)] = false;
      any_skips |= s.skips.exist() || s.passes_water;
      mask.lane[i] = first + static_cast<std::size_t>(i) < shadows_.size() ? -1 : 0;
    }
    use_skips(context, any_skips);
    idle_lanes(mask, packet);
    find_occluded(mask, scene_.rays->scene, context.context, packet);
    for (int i = 0; i < kLanes && mask.lane[i]; ++i) {
      if (packet.tfar[i] < 0) continue;
      add_unblocked(shadows_[first + static_cast<std::size_t>(i)],
                    context.met_water[static_cast<std::size_t>(i)]);
    }
  }
}

/// Embree culls a coherent packet by one frustum, which for scattered origins holds the whole
/// scene, and single rays are then faster than packets.
void PathBatch::trace_shadow_singles() {
  SkipContext context = make_skip_context(*scene_.rays, RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT);
  context.water = &scene_.instances;
  for (const Shadow& s : shadows_) {
    use_skips(context, s.skips.exist() || s.passes_water);
    context.lanes[0] = &s.skips;
    context.passes_water[0] = s.passes_water;
    context.met_water[0] = false;
    RTCRay ray = single_ray(s.origin_m, s.direction, s.far_m, s.time);
    rtcOccluded1(scene_.rays->scene, &context.context, &ray);
    if (ray.tfar >= 0) add_unblocked(s, context.met_water[0]);
  }
}

void PathBatch::add_unblocked(const Shadow& shadow, bool met_water) {
  if (!met_water) {
    radiance_[shadow.index] += shadow.light;
  } else {
    radiance_[shadow.index] += shadow.light.cwiseProduct(through_water(shadow));
  }
}

/// Share of light that comes straight through the water on the way: at each face what is not
/// mirrored of light that comes from the air. Paths carry radiance as it is in the air, so that
/// where light ends in water it counts 1 / n^2, which a path that leaves the water by refraction
/// would find in the solid angle.
Vector3f PathBatch::through_water(const Shadow& shadow) {
  constexpr int kMostFaces = 256;
  SkipContext context = make_skip_context(*scene_.rays, RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT);
  use_skips(context, shadow.skips.exist());
  context.lanes[0] = &shadow.skips;
  Vector3f share = Vector3f::Ones();
  float near_m = 0;
  for (int face = 0; face < kMostFaces; ++face) {
    RTCRayHit ray;
    ray.ray = single_ray(shadow.origin_m, shadow.direction, shadow.far_m, shadow.time);
    ray.ray.tnear = near_m;
    ray.hit.geomID = ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene_.rays->scene, &context.context, &ray);
    ++rays_;
    if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) break;
    const PathHit hit = scene_.hit(ray.hit.instID[0], ray.hit.geomID, ray.hit.primID, ray.hit.u,
                                   ray.hit.v, shadow.direction, shadow.time);
    const float ior = hit.bsdf.material->ior;
    const float entered = hit.bsdf.is_inside ? 1 / (ior * ior) : ior * ior;
    share = share.cwiseProduct((1 - fresnel(hit.bsdf.out.z(), ior)) * entered * hit.bsdf.albedo);
    near_m = beyond(ray.ray.tfar);
  }
  return share;
}

}  // namespace cousin
