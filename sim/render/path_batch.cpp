#include "sim/render/path_batch.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/render/idle_lanes.h"
#include "sim/render/ray_limits.h"
#include "sim/render/subsurface.h"

namespace cousin {
namespace {

using Eigen::Vector3f;

/// Pairs of dimensions a bounce uses: direction, lobe and roulette, choice of light, then lights.
constexpr std::uint32_t kPairsPerBounce = 16;
constexpr float kNoRoulette = -1;
constexpr std::uint32_t kLightPairs = kPairsPerBounce - 3;

float path_luminance(const Vector3f& c) {
  return 0.2126F * c.x() + 0.7152F * c.y() + 0.0722F * c.z();
}

/// Whether light may go between `out` and a direction, by the face and not only by its smooth
/// normal: reflection stays on the face's side, transmission leaves it.
bool sides_agree(const PathHit& hit, const Vector3f& direction, const Vector3f& local) {
  return (hit.face_normal.dot(direction) > 0) == (local.z() > 0);
}

}  // namespace

void PathBatch::clear() {
  paths_.clear();
  samplers_.clear();
  radiance_.clear();
}

void PathBatch::add(const Vector3f& origin_m, const Vector3f& direction, const PathSampler& sampler,
                    float time) {
  const auto index = static_cast<std::uint32_t>(samplers_.size());
  samplers_.push_back(sampler);
  radiance_.emplace_back(Vector3f::Zero());
  if (direction.isZero(0)) return;
  PathState path;
  path.origin_m = origin_m;
  path.direction = direction;
  path.throughput = Vector3f::Ones();
  path.time = time;
  path.index = index;
  paths_.push_back(path);
}

void PathBatch::run() {
  for (int bounce = 0; !paths_.empty(); ++bounce) {
    trace(bounce == 0);
    shade(bounce);
    trace_shadows(bounce == 0);
    std::swap(paths_, next_);
  }
}

void PathBatch::trace(bool is_coherent) {
  hits_.resize(paths_.size());
  rays_ += paths_.size();
  if (is_coherent) {
    trace_packets();
  } else {
    trace_singles();
  }
}

void PathBatch::trace_packets() {
  RTCIntersectContext context = make_context(RTC_INTERSECT_CONTEXT_FLAG_COHERENT);
  HitPacket packet;
  for (std::size_t first = 0; first < paths_.size(); first += kLanes) {
    LaneMask mask;
    for (int i = 0; i < kLanes; ++i) {
      const std::size_t k = std::min(first + static_cast<std::size_t>(i), paths_.size() - 1);
      const PathState& p = paths_[k];
      set_ray(packet.ray, i, p.origin_m.x(), p.origin_m.y(), p.origin_m.z(), p.direction.x(),
              p.direction.y(), p.direction.z());
      packet.ray.time[i] = p.time;
      packet.hit.geomID[i] = kNoGeometry;
      packet.hit.instID[0][i] = kNoGeometry;
      mask.lane[i] = first + static_cast<std::size_t>(i) < paths_.size() ? -1 : 0;
    }
    idle_lanes(mask, packet.ray);
    rtcIntersect16(mask.lane, scene_.rays->scene, &context, &packet);
    for (int i = 0; i < kLanes && mask.lane[i]; ++i) {
      hits_[first + static_cast<std::size_t>(i)] = {packet.hit.instID[0][i], packet.hit.geomID[i],
                                                    packet.hit.primID[i],    packet.hit.u[i],
                                                    packet.hit.v[i],         packet.ray.tfar[i]};
    }
  }
}

void PathBatch::trace_singles() {
  SkipContext context = make_skip_context(*scene_.rays, RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT);
  for (std::size_t k = 0; k < paths_.size(); ++k) {
    const PathState& p = paths_[k];
    use_skips(context, p.skips.exist());
    context.lanes[0] = &p.skips;
    RTCRayHit ray;
    ray.ray = single_ray(p.origin_m, p.direction, kFar, p.time);
    ray.hit.geomID = kNoGeometry;
    ray.hit.instID[0] = kNoGeometry;
    rtcIntersect1(scene_.rays->scene, &context.context, &ray);
    hits_[k] = {ray.hit.instID[0], ray.hit.geomID, ray.hit.primID,
                ray.hit.u,         ray.hit.v,      ray.ray.tfar};
  }
}

/// What shines along the path's ray: lamps before the hit and, beyond everything, sky and suns.
void PathBatch::add_light_behind(const PathState& path, bool missed, float far_m) {
  const SceneLights& lights = scene_.lights;
  const bool is_camera = path.density == 0;  // or sharp
  Vector3f light = Vector3f::Zero();
  for (const auto& lamp : lights.lamps) {
    const float density = hit_lamp(lamp, path.origin_m, path.direction, missed ? kFar : far_m);
    if (density > 0) light += (is_camera ? 1 : share_of(path.density, density)) * lamp.radiance;
  }
  if (missed) {
    light += dome_radiance(lights, path.direction);
    for (const auto& picture : lights.pictures) {
      const bool is_drawn = !is_camera && !picture.row_sums.empty();
      const float share =
          is_drawn ? share_of(path.density, picture_density(picture, path.direction)) : 1;
      light += share * picture_radiance(picture, path.direction);
    }
    for (const auto& sun : lights.suns) {
      if (!hits_sun(sun, path.direction)) continue;
      // Behind water that another surface sees by itself: its shadow rays went straight.
      if (is_camera && path.was_scattered && straight_sun_) continue;
      light +=
          (is_camera ? 1 : share_of(path.density, sun_density(sun, path.direction))) * sun.radiance;
    }
  }
  radiance_[path.index] += path.throughput.cwiseProduct(light);
}

void PathBatch::shade(int bounce_count) {
  next_.clear();
  shadows_.clear();
  const std::uint32_t pair =
      kCameraPairs + static_cast<std::uint32_t>(bounce_count) * kPairsPerBounce;
  for (std::size_t k = 0; k < paths_.size(); ++k) {
    const PathState& path = paths_[k];
    const RayHit& h = hits_[k];
    const bool missed = h.geometry == kNoGeometry;
    add_light_behind(path, missed, h.far_m);
    if (missed || bounce_count > max_bounces_) continue;
    Meeting met;
    met.hit = scene_.hit(h.instance, h.geometry, h.triangle, h.u, h.v, path.direction, path.time);
    if (met.hit.is_dark) continue;
    met.own = {h.instance, h.geometry, h.triangle};
    if (h.far_m < path.touch_m) {
      met.before = path.from;
      met.touches = path.touches + 1;
    }
    scatter(path, met, bounce_count, pair);
  }
}

void PathBatch::scatter(const PathState& path, const Meeting& met, int bounce_count,
                        std::uint32_t pair) {
  const auto shine = [&](const Meeting& from) {
    add_lights(path, from, pair, bounce_count == 0);
    bounce(path, from, bounce_count, pair);
  };
  if (!walks_below(met.hit)) return shine(met);
  if (met.hit.bsdf.material->coat.exists()) {
    Meeting coat = met;
    coat.hit.bsdf.part = PathBsdf::Part::coat;
    shine(coat);
  }
  const PathSampler& sampler = samplers_[path.index];
  const WalkExit exit =
      walk_below(scene_, met.hit, met.own, path.time,
                 sampler.pixel_key + (std::uint64_t{sampler.sample} << 32) + pair);
  rays_ += exit.rays;
  if (!(exit.hit.bsdf.came_out.maxCoeff() > 0)) return;
  Meeting base;
  base.hit = exit.hit;
  base.own = exit.sheet;
  shine(base);
}

/// Shadow rays to every light at the first surface; later to every sun and one other light, chosen
/// by what it would give.
void PathBatch::add_lights(const PathState& path, const Meeting& met, std::uint32_t pair,
                           bool is_first) {
  const PathHit& hit = met.hit;
  if (hit.bsdf.material->kind == SurfaceKind::clear) return;  // lights give it nothing
  const SceneLights& lights = scene_.lights;
  const PathSampler& sampler = samplers_[path.index];
  std::uint32_t light_index = 0;
  const auto next_pair = [&] { return sampler.pair(pair + 3 + light_index++ % kLightPairs); };
  const auto weigh = [&](const Vector3f& direction, float density) -> Vector3f {
    const Vector3f local = hit.frame.transpose() * direction;
    if (!sides_agree(hit, direction, local)) return Vector3f::Zero();
    const PathBsdf::Value value = hit.bsdf.value(local);
    const float share = density > 0 ? share_of(density, value.density) / density : 1;
    return share * path.throughput.cwiseProduct(value.bsdf_cosine);
  };
  const auto offer = [&](std::vector<Shadow>& list, const Vector3f& direction, float far_m,
                         const Vector3f& light, bool passes_water = false) {
    if (!(light.maxCoeff() > 0)) return;
    const PathStart start = met.leave(direction);
    list.push_back({start.origin_m, direction, far_m, path.time, light, path.index, start.skips,
                    passes_water});
  };

  for (const auto& sun : lights.suns) {
    const Vector3f d = draw_sun(sun, next_pair());
    const float density = sun_density(sun, d);
    offer(shadows_, d, kFar, weigh(d, density).cwiseProduct(sun.radiance), straight_sun_);
  }
  candidates_.clear();
  for (const auto& lamp : lights.lamps) {
    const LampDraw draw = draw_lamp(lamp, hit.position_m, next_pair());
    if (!(draw.density > 0)) continue;
    offer(candidates_, draw.direction, draw.distance_m,
          weigh(draw.direction, draw.density).cwiseProduct(lamp.radiance));
  }
  for (const auto& beam : lights.beams) {
    const Vector3f to = beam.origin_m - hit.position_m;
    const float distance2 = to.squaredNorm();
    if (!(distance2 > 0)) continue;
    const Vector3f intensity = beam_intensity(beam, -to);
    if (!(intensity.maxCoeff() > 0)) continue;
    const float distance = std::sqrt(distance2);
    const Vector3f d = to / distance;
    offer(candidates_, d, distance, weigh(d, 0).cwiseProduct(intensity) / distance2, straight_sun_);
  }
  for (const auto& picture : lights.pictures) {
    if (picture.row_sums.empty()) continue;
    const Vector3f d = draw_picture(picture, next_pair());
    const float density = picture_density(picture, d);
    if (!(density > 0)) continue;
    offer(candidates_, d, kFar, weigh(d, density).cwiseProduct(picture_radiance(picture, d)));
  }
  if (is_first || candidates_.size() <= 1) {
    shadows_.insert(shadows_.end(), candidates_.begin(), candidates_.end());
    return;
  }
  float total = 0;
  for (const Shadow& c : candidates_) total += path_luminance(c.light);
  float left = sampler.pair(pair + 2).x() * total;
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    const float own = path_luminance(candidates_[i].light);
    left -= own;
    if (left >= 0 && i + 1 < candidates_.size()) continue;
    if (own > 0) {
      shadows_.push_back(candidates_[i]);
      shadows_.back().light *= total / own;
    }
    return;
  }
}

void PathBatch::bounce(const PathState& path, const Meeting& met, int bounce_count,
                       std::uint32_t pair) {
  const PathBsdf& bsdf = met.hit.bsdf;
  if (bounce_count == 0 && bsdf.material->kind == SurfaceKind::clear) {
    // What a camera sees in water and through it are both followed: bright glints are a small
    // share.
    for (const bool reflects : {true, false})
      go_on(path, met, bsdf.clear_way(reflects), kNoRoulette);
    return;
  }
  const PathSampler& sampler = samplers_[path.index];
  const Eigen::Vector2f choice = sampler.pair(pair + 1);
  go_on(path, met, bsdf.draw(sampler.pair(pair), choice.x()),
        bounce_count > 0 ? choice.y() : kNoRoulette);
}

/// @param roulette  in [0, 1): which paths that carry little end; or kNoRoulette.
void PathBatch::go_on(const PathState& path, const Meeting& met, const PathBsdf::Draw& draw,
                      float roulette) {
  const PathHit& hit = met.hit;
  if (!(draw.weight.maxCoeff() > 0)) return;
  PathState next;
  next.index = path.index;
  next.time = path.time;
  next.density = draw.is_sharp ? 0 : std::max(draw.density, 1e-20F);
  next.throughput = path.throughput.cwiseProduct(draw.weight);
  next.was_scattered = path.was_scattered || !draw.is_sharp;
  // A long path goes on by the root of what it carries: of throughput, twice that, its root and
  // always, the root had the least error for its time on the leafy scene.
  if (roulette >= 0) {
    const float kept = std::min(std::sqrt(next.throughput.maxCoeff()), 1.0F);
    if (roulette >= kept) return;
    next.throughput /= kept;
  }
  next.direction = hit.frame * draw.in;
  if (!sides_agree(hit, next.direction, draw.in)) {
    // Through the face though on the smooth normal's side: mirrored, so that no energy is lost.
    next.direction -= 2 * hit.face_normal.dot(next.direction) * hit.face_normal;
  }
  next.direction.normalize();
  const PathStart start = met.leave(next.direction);
  next.origin_m = start.origin_m;
  next.skips = start.skips;
  next.touch_m = start.touch_m;
  next.from = met.own;
  next.touches = met.touches > kMostTouches ? 0 : met.touches;
  next_.push_back(next);
}

}  // namespace cousin
