#include "sim/render/infrared_pass.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/config/limits.h"
#include "sim/render/infrared_light.h"
#include "sim/render/ray_scene_impl.h"
#include "sim/render/ray_table.h"
#include "sim/render/sample_points.h"
#include "sim/truth/scene_check.h"

namespace cousin {
namespace {

constexpr float kInversePi = std::numbers::inv_pi_v<float>;
constexpr unsigned int kNone = RTC_INVALID_GEOMETRY_ID;

/// Where a ray met a surface.
struct Hit {
  Eigen::Vector3f position_m;
  Eigen::Vector3f normal;  ///< of the face, towards where the ray came from
  float offset_m = 0;      ///< how far off the surface rays must start
  InfraredSurface::Share share;
};

Hit resolve(const RayScene::Impl& impl, const std::vector<InfraredSurface>& surfaces,
            const HitPacket& packet, int i, const Eigen::Vector3f& direction) {
  const SurfacePoint point =
      surface_point(impl, packet.hit.instID[0][i], packet.hit.geomID[i], packet.hit.primID[i],
                    packet.hit.u[i], packet.hit.v[i], direction);
  Hit hit;
  hit.position_m = point.position_m;
  hit.normal = point.face_normal;
  hit.offset_m = point.offset_m;
  hit.share = surfaces[point.geometry].at(hit.position_m, point.has_print);
  return hit;
}

/// Radiance per irradiance of light that arrives from `to_light`, with its cosine.
float response(const Hit& hit, const Eigen::Vector3f& to_light) {
  const float cosine = hit.normal.dot(to_light);
  return kInversePi * (cosine > 0 ? hit.share.albedo * cosine : -hit.share.transmittance * cosine);
}

/// Gamma variable of mean 1 and the given sigma, from a hash [Wilson & Hilferty 1931]: its mean is
/// exact to sigma^6 / 729.
float speckle(std::uint64_t hash, float contrast) {
  const Eigen::Vector2f u = unit_pair(hash);
  const float z = std::sqrt(-2 * std::log(1 - u.x())) *
                  std::cos(2 * std::numbers::pi_v<float> * u.y());  // Box and Muller
  const float a = contrast * contrast / 9;
  const float root = std::max(0.0F, 1 - a + z * std::sqrt(a));
  return root * root * root;
}

/// Samples of one packet and what comes back.
struct Samples {
  LaneMask mask;
  Eigen::Vector3f origin_m;
  Eigen::Vector3f direction[kLanes];
  float steady[kLanes];     ///< radiance by sun and sky
  float projected[kLanes];  ///< and by projectors
  bool met[kLanes];         ///< a surface
  Hit hit[kLanes];
};

class PacketShader {
 public:
  PacketShader(const RayScene::Impl& impl, const InfraredLights& lights,
               const std::vector<InfraredSurface>& surfaces)
      : impl_(impl),
        lights_(lights),
        surfaces_(surfaces),
        context_(make_context(RTC_INTERSECT_CONTEXT_FLAG_COHERENT)) {}

  void operator()(Samples& s) {
    for (int i = 0; i < kLanes; ++i) {
      set_ray(camera_.ray, i, s.origin_m.x(), s.origin_m.y(), s.origin_m.z(), s.direction[i].x(),
              s.direction[i].y(), s.direction[i].z());
      camera_.hit.geomID[i] = kNone;
      s.steady[i] = s.projected[i] = 0;
      s.met[i] = false;
    }
    rtcIntersect16(s.mask.lane, impl_.scene, &context_, &camera_);
    for (int i = 0; i < kLanes; ++i) {
      if (!s.mask.lane[i] || camera_.hit.geomID[i] == kNone) continue;
      s.met[i] = true;
      s.hit[i] = resolve(impl_, surfaces_, camera_, i, s.direction[i]);
      add_unshadowed(s, i);
    }
    for (const auto& projector : lights_.projectors) add_projector(s, projector);
    for (const auto& sun : lights_.suns) add_sun(s, sun);
  }

 private:
  void add_unshadowed(Samples& s, int i) const {
    const Hit& hit = s.hit[i];
    s.steady[i] += kInversePi * (hit.share.albedo * lights_.ambient_at(hit.normal.z()) +
                                 hit.share.transmittance * lights_.ambient_at(-hit.normal.z()));
    for (const auto& lamp : lights_.lamps) {
      const Eigen::Vector3f way = lamp.origin_m - hit.position_m;
      const float squared = way.squaredNorm();
      const Eigen::Vector3f d = way / std::sqrt(squared);
      const float facing = -lamp.normal.dot(d);
      if (facing > 0) s.steady[i] += response(hit, d) * lamp.intensity * facing / squared;
    }
  }

  /// Starts a shadow ray of lane i towards a light that would give it `light`.
  void aim(const Hit& hit, int i, const Eigen::Vector3f& d, float far_m, float light) {
    mask_.lane[i] = 0;
    if (!(light > 0)) return;
    const Eigen::Vector3f o = offset_origin(hit.position_m, hit.normal, hit.offset_m, d);
    set_ray(shadow_, i, o.x(), o.y(), o.z(), d.x(), d.y(), d.z(), far_m);
    mask_.lane[i] = -1;
    light_[i] = light;
  }

  void add_unblocked(float* radiance) {
    find_occluded(mask_, impl_.scene, context_, shadow_);
    for (int i = 0; i < kLanes; ++i) {
      if (mask_.lane[i] && shadow_.tfar[i] >= 0) radiance[i] += light_[i];
    }
  }

  void add_projector(Samples& s, const InfraredProjector& projector) {
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
    add_unblocked(s.projected);
  }

  void add_sun(Samples& s, const InfraredLights::Sun& sun) {
    for (int i = 0; i < kLanes; ++i) {
      mask_.lane[i] = 0;
      if (!s.met[i]) continue;
      aim(s.hit[i], i, sun.to_sun, std::numeric_limits<float>::infinity(),
          response(s.hit[i], sun.to_sun) * sun.irradiance);
    }
    add_unblocked(s.steady);
  }

  const RayScene::Impl& impl_;
  const InfraredLights& lights_;
  const std::vector<InfraredSurface>& surfaces_;
  RTCIntersectContext context_;
  HitPacket camera_;
  ShadowPacket shadow_;
  LaneMask mask_;
  float light_[kLanes];
};

/// Sums of one pixel's samples.
struct PixelSum {
  float steady = 0, projected = 0, gain = 1;
  int met = 0, lit = 0, count = 0;
};

/// Renders rows of one view.
class RowRenderer {
 public:
  RowRenderer(PacketShader shade, const TrueView& view, const std::vector<Eigen::Vector3d>& corners,
              const InfraredConfig& config, std::uint64_t key, const Eigen::Vector3d& centre_m)
      : shade_(shade),
        view_(view),
        corners_(corners),
        config_(config),
        key_(key),
        centre_m_(centre_m),
        sums_(static_cast<std::size_t>(view.camera.width_px)) {}

  void operator()(int y, InfraredImage& out) {
    const int width = view_.camera.width_px;
    const int side = static_cast<int>(std::lround(std::sqrt(config_.pixel_samples)));
    const Pose camera_from_world = pose_at_row(view_, y);
    const Eigen::Matrix3f world_from_camera =
        camera_from_world.rotation.conjugate().toRotationMatrix().cast<float>();
    samples_.origin_m = (centre_in_world_m(camera_from_world) - centre_m_).cast<float>();
    std::fill(sums_.begin(), sums_.end(), PixelSum{});
    int lane = 0;
    for (int x = 0; x < width; ++x) {
      const std::uint64_t hash = pixel_hash(x, y);
      const std::size_t first = static_cast<std::size_t>(y) * static_cast<std::size_t>(width + 1) +
                                static_cast<std::size_t>(x);
      const Eigen::Vector3d* above = corners_.data() + first;
      const Eigen::Vector3d* below = above + width + 1;
      if (above[0].isZero(0) || above[1].isZero(0) || below[0].isZero(0) || below[1].isZero(0))
        continue;
      for (int k = 0; k < side * side; ++k) {
        const Eigen::Vector2f jitter = unit_pair(hash64(hash + static_cast<std::uint64_t>(k + 1)));
        const double u = (k % side + static_cast<double>(jitter.x())) / side;
        const double v = (k / side + static_cast<double>(jitter.y())) / side;
        const Eigen::Vector3d d =
            (above[0] * (1 - u) + above[1] * u) * (1 - v) + (below[0] * (1 - u) + below[1] * u) * v;
        samples_.direction[lane] = world_from_camera * d.normalized().cast<float>();
        samples_.mask.lane[lane] = -1;
        column_[lane] = x;
        if (++lane == kLanes) flush(lane, y);
      }
    }
    if (lane > 0) flush(lane, y);
    for (int x = 0; x < width; ++x) {
      const PixelSum& sum = sums_[static_cast<std::size_t>(x)];
      const auto count = static_cast<float>(std::max(sum.count, 1));
      out.radiance(x, y) = (sum.steady + sum.gain * sum.projected) / count;
      out.projected(x, y) =
          sum.met > 0 ? static_cast<float>(sum.lit) / static_cast<float>(sum.met) : 0.0F;
    }
  }

 private:
  std::uint64_t pixel_hash(int x, int y) const {
    return hash64(key_ + (static_cast<std::uint64_t>(y) << 32) + static_cast<std::uint64_t>(x));
  }

  void flush(int& lanes, int y) {
    for (int i = lanes; i < kLanes; ++i) samples_.mask.lane[i] = 0;
    shade_(samples_);
    for (int i = 0; i < lanes; ++i) {
      PixelSum& sum = sums_[static_cast<std::size_t>(column_[i])];
      if (sum.met == 0 && samples_.met[i] && config_.speckle_contrast > 0)
        sum.gain = gain_at(samples_.hit[i], column_[i], y);
      sum.steady += samples_.steady[i];
      sum.projected += samples_.projected[i];
      sum.met += samples_.met[i] ? 1 : 0;
      sum.lit += samples_.projected[i] > 0 ? 1 : 0;
      ++sum.count;
    }
    lanes = 0;
  }

  float gain_at(const Hit& hit, int x, int y) const {
    const float footprint_m =
        (hit.position_m - samples_.origin_m).norm() / static_cast<float>(view_.camera.fx_px);
    const float cell_m = std::exp2(std::floor(std::log2(footprint_m / 8)));
    std::uint64_t hash = pixel_hash(x, y);
    for (int k = 0; k < 3; ++k) {
      const auto cell = static_cast<std::int64_t>(std::floor(hit.position_m[k] / cell_m));
      hash = hash64(hash + static_cast<std::uint64_t>(cell));
    }
    return speckle(hash, static_cast<float>(config_.speckle_contrast));
  }

  PacketShader shade_;
  const TrueView& view_;
  const std::vector<Eigen::Vector3d>& corners_;
  const InfraredConfig& config_;
  std::uint64_t key_;
  Eigen::Vector3d centre_m_;
  std::vector<PixelSum> sums_;
  Samples samples_;
  int column_[kLanes];
};

}  // namespace

Fields fields(InfraredConfig& c) {
  return {
      {"pixel_samples", &c.pixel_samples, "samples a pixel; a square number", 1, 4096},
      {"sun_share", &c.sun_share, "a sun's infrared irradiance over the mean of its colours", 0,
       1e3},
      {"sky_share", &c.sky_share, "the same of skies and environments", 0, 1e3},
      {"lamp_share", &c.lamp_share, "the same of lamps; 0 for LEDs", 0, 1e3},
      {"speckle_contrast", &c.speckle_contrast, "sigma over mean of projected light in a pixel", 0,
       1},
  };
}

void validate(const InfraredConfig& config) {
  InfraredConfig copy = config;
  check_limits(fields(copy), "infrared");
  const auto side = static_cast<int>(std::lround(std::sqrt(config.pixel_samples)));
  if (side * side != config.pixel_samples) {
    throw std::invalid_argument("infrared: pixel_samples = " +
                                std::to_string(config.pixel_samples) + " is not a square number");
  }
}

InfraredImage render_infrared(const RayScene& rays, const Scene& scene, const TrueView& view,
                              std::span<const Projector> projectors, const InfraredConfig& config,
                              Rng rng) {
  validate(config);
  validate(view);
  const RayScene::Impl& impl = rays.impl();
  if (scene.instances.size() != impl.geometries.size()) {
    throw std::invalid_argument("infrared pass: the scene \"" + scene.name +
                                "\" is not the one of the rays");
  }
  const int width = view.camera.width_px, height = view.camera.height_px;
  const InfraredLights lights = make_infrared_lights(scene, projectors, config, impl.centre_m);
  const auto surfaces = make_infrared_surfaces(scene, impl.span_s.begin_s, impl.centre_m);
  const auto corners = lens_directions(view.camera, -0.5, -0.5, width + 1, height + 1, 1e-4);
  const std::uint64_t key = rng.fork("infrared")();
  InfraredImage image{Image<float>(width, height), Image<float>(width, height)};
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 8), [&](const auto& range) {
    const FlushDenormals flush;
    RowRenderer render(PacketShader(impl, lights, surfaces), view, corners, config, key,
                       impl.centre_m);
    for (int y = range.begin(); y < range.end(); ++y) render(y, image);
  });
  return image;
}

}  // namespace cousin
