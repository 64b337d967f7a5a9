#include "sim/render/radiance_pass.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/render/idle_lanes.h"
#include "sim/render/pixel_rays.h"
#include "sim/render/ray_limits.h"
#include "sim/render/sample_points.h"
#include "sim/render/surface_light.h"
#include "sim/truth/scene_check.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {

float radiance_luminance(const Eigen::Vector3f& c) {
  return 0.2126F * c.x() + 0.7152F * c.y() + 0.0722F * c.z();
}

/// What a sample shows, for telling edges: geometry, print and lit suns.
constexpr std::uint32_t kSky = 0xFFFFFFFEU;
constexpr std::uint32_t kMixed = 0xFFFFFFFFU;

/// Power heuristic: share of a sample drawn with density `own` where another way has density
/// `other`. A lamp is far denser than a rough coat, so stray reflections that meet it then add
/// little noise.
float share_by_squares(float own, float other) { return own * own / (own * own + other * other); }

/// Rays of one packet and what comes back.
struct SamplePacket {
  LaneMask mask;
  Eigen::Vector3f origin_m;
  Eigen::Vector3f direction[kLanes];
  std::uint64_t hash[kLanes];    ///< of the pixel: shifts each dimension's points
  std::uint32_t sample[kLanes];  ///< index of the sample in its pixel
  float gloss_weight[kLanes];    ///< of the coat's reflection of lamps, sky and scene; 0 = not
                                 ///< sampled here
  Eigen::Vector3f radiance[kLanes];
  float diffuse[kLanes];  ///< radiance_luminance of the cached part
  std::uint32_t key[kLanes];
};

/// Shades a packet of camera rays.
class PacketShader {
 public:
  explicit PacketShader(const IrradianceCache::Impl& cache)
      : cache_(cache), context_(make_context(RTC_INTERSECT_CONTEXT_FLAG_COHERENT)) {}

  void operator()(SamplePacket& s) {
    for (int i = 0; i < kLanes; ++i) {
      set_ray(camera_.ray, i, s.origin_m.x(), s.origin_m.y(), s.origin_m.z(), s.direction[i].x(),
              s.direction[i].y(), s.direction[i].z());
      camera_.hit.geomID[i] = kNoGeometry;
      s.radiance[i].setZero();
      s.diffuse[i] = 0;
      s.key[i] = kSky;
    }
    idle_lanes(s.mask, camera_.ray);
    rtcIntersect16(s.mask.lane, cache_.rays->scene, &context_, &camera_);
    for (int i = 0; i < kLanes; ++i) {
      lit_.lane[i] = 0;
      if (s.mask.lane[i]) first_hit(s, i);
    }
    for (std::size_t k = 0; k < cache_.lights.suns.size(); ++k) add_sun(s, k);
    for (std::size_t k = 0; k < cache_.lights.lamps.size(); ++k) add_lamp_gloss(s, k);
    add_reflection(s);
  }

 private:
  /// A surface under a camera ray; directions in the frame have z along the shading normal.
  struct LaneSurface {
    SurfaceHit hit;
    Eigen::Matrix3f frame;
    Eigen::Vector3f out;             ///< towards the camera, in the frame
    Eigen::Vector3f per_irradiance;  ///< radiance of the base per irradiance that enters it
    bool has_coat = false;
    float gloss_weight = 0;
    float gloss_threshold = 0;
  };

  Eigen::Vector2f draw(const SamplePacket& s, int i, std::uint64_t dimension) const {
    return rotated(sobol_point(s.sample[i]), unit_pair(hash64(s.hash[i] + dimension)));
  }

  void first_hit(SamplePacket& s, int i) {
    const Eigen::Vector3f& d = s.direction[i];
    const bool missed = camera_.hit.geomID[i] == kNoGeometry;
    for (const auto& lamp : cache_.lights.lamps) {  // lamps add to what lies behind them
      if (hit_lamp(lamp, s.origin_m, d, missed ? kFar : camera_.ray.tfar[i]) > 0)
        s.radiance[i] += lamp.radiance;
    }
    if (missed) {
      s.radiance[i] += sky_radiance(cache_.lights, d) + sun_radiance(cache_.lights, d);
      return;
    }
    LaneSurface& lane = lanes_[i];
    lane.hit = surface_hit(cache_, camera_.hit.geomID[i], camera_.hit.primID[i], camera_.hit.u[i],
                           camera_.hit.v[i], d);
    const SurfaceAlbedo albedo = albedo_at(lane.hit);
    const Eigen::Vector3f n = shading_normal(lane.hit);
    const Coat& coat = lane.hit.surface->coat;
    const float cosine =
        std::max(-n.dot(d), 1e-3F);  // a shading normal may turn away at the outline
    lane.per_irradiance = kInversePiF * coat.leaving(cosine) * albedo.albedo;
    const Eigen::Vector3f diffuse =
        lane.per_irradiance.cwiseProduct(cached_irradiance(cache_, lane.hit));
    s.radiance[i] += diffuse;
    s.diffuse[i] = radiance_luminance(diffuse);
    s.key[i] = camera_.hit.geomID[i] * 64 + (albedo.is_ink ? 32U : 0U);
    lit_.lane[i] = -1;
    const bool is_dark_side = lane.hit.is_back && lane.hit.surface->back_points == 0;
    lane.has_coat = coat.exists() && !is_dark_side;
    lane.gloss_weight = lane.has_coat ? s.gloss_weight[i] : 0;
    lane.frame = frame_about(n);
    lane.out = lane.frame.transpose() * -d;
    lane.out.z() = cosine;
    // One per cent of the base's radiance, or of a mirror's share of it where the base is black.
    lane.gloss_threshold = 0.01F * s.diffuse[i];
  }

  /// One ray to each sun's disk: sharp shadows are not cached.
  void add_sun(SamplePacket& s, std::size_t k) {
    const auto& sun = cache_.lights.suns[k];
    ShadowPacket shadow;
    LaneMask mask;
    Eigen::Vector3f light[kLanes];
    for (int i = 0; i < kLanes; ++i) {
      mask.lane[i] = 0;
      if (!lit_.lane[i]) continue;
      const LaneSurface& lane = lanes_[i];
      if (lane.hit.is_back && lane.hit.surface->back_points == 0) continue;
      const Eigen::Vector3f d = draw_sun(sun, draw(s, i, 100 + k));
      const Eigen::Vector3f in = lane.frame.transpose() * d;
      if (in.z() <= 0 || lane.hit.face_normal.dot(d) <= 0) continue;
      const Coat& coat = lane.hit.surface->coat;
      const float gloss = lane.has_coat ? coat.value(lane.out, in).brdf_cosine : 0;
      light[i] = sun.irradiance.cwiseProduct(in.z() * coat.entering(in.z()) * lane.per_irradiance +
                                             Eigen::Vector3f::Constant(gloss));
      const Eigen::Vector3f o = leave(lane.hit, d);
      set_ray(shadow, i, o.x(), o.y(), o.z(), d.x(), d.y(), d.z());
      mask.lane[i] = -1;
    }
    idle_lanes(mask, shadow);
    find_occluded(mask, cache_.rays->scene, context_, shadow);
    for (int i = 0; i < kLanes; ++i) {
      if (!mask.lane[i] || shadow.tfar[i] < 0) continue;
      s.radiance[i] += light[i];
      s.key[i] ^= 1U << (k % 5);
    }
  }

  /// The coat's reflection of one lamp by a point drawn on the lamp; the other half of the power
  /// heuristic [Veach 1997] is in add_reflection. Faint draws are kept by Russian roulette, so
  /// nothing is lost on average.
  void add_lamp_gloss(SamplePacket& s, std::size_t k) {
    const auto& lamp = cache_.lights.lamps[k];
    ShadowPacket shadow;
    LaneMask mask;
    float light[kLanes];
    bool any = false;
    for (int i = 0; i < kLanes; ++i) {
      mask.lane[i] = 0;
      if (!lit_.lane[i] || lanes_[i].gloss_weight <= 0) continue;
      const LaneSurface& lane = lanes_[i];
      const LampDraw point = draw_lamp(lamp, lane.hit.position_m, draw(s, i, 200 + k));
      if (point.density <= 0 || lane.hit.face_normal.dot(point.direction) <= 0) continue;
      const Coat::Value value =
          lane.hit.surface->coat.value(lane.out, lane.frame.transpose() * point.direction);
      if (value.brdf_cosine <= 0) continue;
      light[i] = lane.gloss_weight * value.brdf_cosine / point.density *
                 share_by_squares(point.density, value.density);
      const float strength = light[i] * radiance_luminance(lamp.radiance);
      if (strength < lane.gloss_threshold) {
        const float kept = strength / lane.gloss_threshold;
        if (unit_pair(hash64(s.hash[i] + 300 + 16 * s.sample[i] + k)).x() >= kept) continue;
        light[i] /= kept;
      }
      const Eigen::Vector3f o = leave(lane.hit, point.direction);
      set_ray(shadow, i, o.x(), o.y(), o.z(), point.direction.x(), point.direction.y(),
              point.direction.z(), point.distance_m);
      mask.lane[i] = -1;
      any = true;
    }
    if (!any) return;
    idle_lanes(mask, shadow);
    find_occluded(mask, cache_.rays->scene, context_, shadow);
    for (int i = 0; i < kLanes; ++i) {
      if (mask.lane[i] && shadow.tfar[i] >= 0) s.radiance[i] += light[i] * lamp.radiance;
    }
  }

  /// The coat's reflection of sky, lamps and scene by a direction drawn from the coat.
  void add_reflection(SamplePacket& s) {
    HitPacket packet;
    LaneMask mask;
    Eigen::Vector3f direction[kLanes];
    Coat::Draw drawn[kLanes];
    bool any = false;
    for (int i = 0; i < kLanes; ++i) {
      mask.lane[i] = 0;
      if (!lit_.lane[i] || lanes_[i].gloss_weight <= 0) continue;
      const LaneSurface& lane = lanes_[i];
      drawn[i] = lane.hit.surface->coat.draw(lane.out, draw(s, i, 1));
      if (drawn[i].weight <= 0) continue;
      drawn[i].weight *= lane.gloss_weight;
      direction[i] = lane.frame * drawn[i].in;
      if (lane.hit.face_normal.dot(direction[i]) <= 0) {
        // Below the face though above the shading normal's horizon: it would meet the surface
        // itself.
        const float reflected = lane.hit.surface->coat.reflected(lane.out.z());
        s.radiance[i] += drawn[i].weight *
                         (lane.per_irradiance + Eigen::Vector3f::Constant(kInversePiF * reflected))
                             .cwiseProduct(cached_irradiance(cache_, lane.hit));
        continue;
      }
      const Eigen::Vector3f o = leave(lane.hit, direction[i]);
      set_ray(packet.ray, i, o.x(), o.y(), o.z(), direction[i].x(), direction[i].y(),
              direction[i].z());
      packet.hit.geomID[i] = kNoGeometry;
      mask.lane[i] = -1;
      any = true;
    }
    if (!any) return;
    idle_lanes(mask, packet.ray);
    rtcIntersect16(mask.lane, cache_.rays->scene, &context_, &packet);
    for (int i = 0; i < kLanes; ++i) {
      secondary_.mask.lane[i] = 0;
      if (!mask.lane[i]) continue;
      const bool missed = packet.hit.geomID[i] == kNoGeometry;
      const Eigen::Vector3f origin(packet.ray.org_x[i], packet.ray.org_y[i], packet.ray.org_z[i]);
      for (const auto& lamp : cache_.lights.lamps) {
        const float density =
            hit_lamp(lamp, origin, direction[i], missed ? kFar : packet.ray.tfar[i]);
        if (density <= 0) continue;
        s.radiance[i] +=
            drawn[i].weight * share_by_squares(drawn[i].density, density) * lamp.radiance;
      }
      if (missed) {
        s.radiance[i] += drawn[i].weight * sky_radiance(cache_.lights, direction[i]);
        continue;
      }
      secondary_.mask.lane[i] = -1;
      secondary_.hit[i] = surface_hit(cache_, packet.hit.geomID[i], packet.hit.primID[i],
                                      packet.hit.u[i], packet.hit.v[i], direction[i]);
      secondary_.light[i] = secondary_light(cache_, secondary_.hit[i], direction[i]);
      secondary_.hash[i] = hash64(s.hash[i] + 1000 + s.sample[i]);
    }
    if (!cache_.lights.suns.empty()) add_suns(cache_, secondary_);
    for (int i = 0; i < kLanes; ++i) {
      if (secondary_.mask.lane[i]) s.radiance[i] += drawn[i].weight * secondary_.light[i].radiance;
    }
  }

  const IrradianceCache::Impl& cache_;
  RTCIntersectContext context_;
  HitPacket camera_;
  LaneMask lit_;  ///< lanes whose camera ray met a surface
  LaneSurface lanes_[kLanes];
  SecondaryPacket secondary_;
};

int square_side(int samples) { return static_cast<int>(std::lround(std::sqrt(samples))); }

/// Mean of a pixel's samples and what tells an edge.
struct PixelMean {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  std::uint32_t key = kSky;
  float low = kFar, high = 0;  ///< of the samples' cached radiance_luminance
  int count = 0;

  void add(const SamplePacket& s, int i) {
    sum += s.radiance[i];
    key = count == 0 || key == s.key[i] ? s.key[i] : kMixed;
    low = std::min(low, s.diffuse[i]);
    high = std::max(high, s.diffuse[i]);
    ++count;
  }
  Rgbf mean() const {
    const Eigen::Vector3f m = sum / static_cast<float>(std::max(count, 1));
    return {m.x(), m.y(), m.z()};
  }
  std::uint32_t edge_key() const { return high > 1.1F * low ? kMixed : key; }
};

/// Renders pixels of one view; one for each task, as it holds packets.
class PixelRenderer {
 public:
  PixelRenderer(const IrradianceCache::Impl& cache, const PixelRays& rays, std::uint64_t key,
                int width)
      : shade_(cache), rays_(rays), key_(key), width_(width) {}

  /// Pixels (x, y) of `columns`, `side` x `side` strata each; packets run across pixels.
  template <class Store>
  void render(int y, const std::vector<int>& columns, int side, std::uint64_t round,
              const Store& store) {
    const std::size_t samples = static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
    packet_.origin_m = rays_.origin_m(y);
    means_.assign(columns.size(), PixelMean{});
    PixelRays::Corners corners;
    std::uint64_t hash = 0;
    int lane = 0;
    std::size_t lane_pixel[kLanes];
    const auto flush = [&] {
      for (int i = lane; i < kLanes; ++i) packet_.mask.lane[i] = 0;
      shade_(packet_);
      for (int i = 0; i < lane; ++i) means_[lane_pixel[i]].add(packet_, i);
      lane = 0;
    };
    for (std::size_t c = 0; c < columns.size(); ++c) {
      corners = rays_.corners(columns[c], y);
      if (!corners.valid) continue;
      const auto pixel = static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(width_) +
                         static_cast<std::uint64_t>(columns[c]);
      hash = hash64(key_ + 2 * pixel + round);
      for (std::size_t k = 0; k < samples; ++k) {
        const auto n = static_cast<std::size_t>(side);
        const Eigen::Vector2f jitter = unit_pair(hash64(hash + (k << 32)));
        const Eigen::Vector2f p =
            (Eigen::Vector2f(static_cast<float>(k % n), static_cast<float>(k / n)) + jitter) /
            static_cast<float>(side);
        packet_.mask.lane[lane] = -1;
        packet_.direction[lane] = corners.at(p);
        packet_.hash[lane] = hash;
        packet_.sample[lane] = static_cast<std::uint32_t>(k);
        packet_.gloss_weight[lane] = gloss_weight(k % n, k / n, hash, round);
        lane_pixel[lane] = c;
        if (++lane == kLanes) flush();
      }
    }
    if (lane > 0) flush();
    for (std::size_t c = 0; c < columns.size(); ++c) store(columns[c], means_[c]);
  }

 private:
  /// At edges every fourth stratum, from a random start, samples the coat for all four: what varies
  /// there is the surface, not its gloss.
  static float gloss_weight(std::size_t column, std::size_t row, std::uint64_t hash,
                            std::uint64_t round) {
    if (round == 0) return 1;
    return (column + 2 * row + hash) % 4 == 0 ? 4 : 0;
  }

  PacketShader shade_;
  const PixelRays& rays_;
  std::uint64_t key_;
  int width_;
  SamplePacket packet_;
  std::vector<PixelMean> means_;
};

/// Whether samples differ here, or some neighbour shows something else. A direct neighbour that is
/// mixed counts too: what it shows may reach into this pixel between its few samples.
bool is_edge(const Image<std::uint32_t>& keys, int x, int y) {
  const std::uint32_t key = keys(x, y);
  if (key == kMixed) return true;
  for (int j = std::max(y - 1, 0); j <= std::min(y + 1, keys.height() - 1); ++j) {
    for (int i = std::max(x - 1, 0); i <= std::min(x + 1, keys.width() - 1); ++i) {
      const bool is_direct = i == x || j == y;
      if (keys(i, j) != key && (is_direct || keys(i, j) != kMixed)) return true;
    }
  }
  return false;
}

}  // namespace

Fields fields(RadianceConfig& c) {
  return {
      {"pixel_samples", &c.pixel_samples, "samples a pixel; a square number", 4, 4096},
      {"edge_samples", &c.edge_samples, "samples a pixel at edges; a square number", 4, 65536},
      {"irradiance_samples", &c.irradiance_samples, "paths a point of the irradiance cache", 16,
       1 << 20},
      {"max_bounces", &c.max_bounces, "diffuse bounces of those paths", 0, 64},
      {"board_texel_m", &c.board_texel_m, "spacing of cache points on specimens and print", 1e-9,
       1e3},
  };
}

void validate(const RadianceConfig& config) {
  const auto fail = [](const char* field, double value, const char* limit) {
    throw std::invalid_argument(std::string("radiance: ") + field + " = " + std::to_string(value) +
                                " " + limit);
  };
  const auto is_square = [](int n) { return square_side(n) * square_side(n) == n; };
  if (config.pixel_samples < 4 || config.pixel_samples > 4096 || !is_square(config.pixel_samples)) {
    fail("pixel_samples", config.pixel_samples, "is not a square number in 4..4096");
  }
  if (config.edge_samples < 4 || config.edge_samples > 65536 || !is_square(config.edge_samples)) {
    fail("edge_samples", config.edge_samples, "is not a square number in 4..65536");
  }
  if (config.irradiance_samples < 16 || config.irradiance_samples > 1 << 20) {
    fail("irradiance_samples", config.irradiance_samples, "is not in 16..1048576");
  }
  if (config.max_bounces < 0 || config.max_bounces > 64)
    fail("max_bounces", config.max_bounces, "is not in 0..64");
  if (!(config.board_texel_m >= 1e-9 && config.board_texel_m <= 1e3)) {
    fail("board_texel_m", config.board_texel_m, "is not in [1e-9, 1e3]");
  }
}

Image<Rgbf> render_radiance(const RayScene& rays, const Scene& scene, const IrradianceCache& cache,
                            const TrueView& view, const RadianceConfig& config, Rng rng) {
  validate(config);
  validate(view);
  if (cache.impl().rays != &rays.impl() ||
      scene.instances.size() != rays.impl().geometries.size()) {
    throw std::invalid_argument("radiance pass: the cache or the scene \"" + scene.name +
                                "\" is not of these rays");
  }
  const int width = view.camera.width_px, height = view.camera.height_px;
  const PixelRays pixel_rays(view, rays.impl().centre_m);
  const std::uint64_t key = rng.fork("pixels")();
  Image<Rgbf> image(width, height);
  Image<std::uint32_t> keys(width, height);

  std::vector<int> all_columns(static_cast<std::size_t>(width));
  for (int x = 0; x < width; ++x) all_columns[static_cast<std::size_t>(x)] = x;
  const auto for_rows = [&](const auto& function) {
    tbb::parallel_for(tbb::blocked_range<int>(0, height, 8),
                      [&](const tbb::blocked_range<int>& range) {
                        const FlushDenormals flush;
                        PixelRenderer renderer(cache.impl(), pixel_rays, key, width);
                        for (int y = range.begin(); y < range.end(); ++y) function(renderer, y);
                      });
  };
  for_rows([&](PixelRenderer& renderer, int y) {
    renderer.render(y, all_columns, square_side(config.pixel_samples), 0,
                    [&](int x, const PixelMean& pixel) {
                      image(x, y) = pixel.mean();
                      keys(x, y) = pixel.edge_key();
                    });
  });
  // Edges are drawn anew, so that what chose them does not bias them.
  for_rows([&](PixelRenderer& renderer, int y) {
    std::vector<int> columns;
    for (int x = 0; x < width; ++x) {
      if (is_edge(keys, x, y)) columns.push_back(x);
    }
    renderer.render(y, columns, square_side(config.edge_samples), 1,
                    [&](int x, const PixelMean& pixel) { image(x, y) = pixel.mean(); });
  });
  return image;
}

}  // namespace cousin
