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
#include "sim/render/infrared_shader.h"
#include "sim/render/infrared_sky.h"
#include "sim/render/ray_scene_impl.h"
#include "sim/render/ray_table.h"
#include "sim/render/sample_points.h"
#include "sim/truth/scene_check.h"

namespace cousin {
namespace {

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

/// Sums of one pixel's samples.
struct InfraredSum {
  float steady = 0, projected = 0, gain = 1;
  int met = 0, lit = 0, count = 0;
};

/// Renders rows of one view.
class RowRenderer {
 public:
  RowRenderer(InfraredShader shade, const TrueView& view,
              const std::vector<Eigen::Vector3d>& corners, const InfraredConfig& config,
              std::uint64_t key, const Eigen::Vector3d& centre_m)
      : shade_(shade),
        view_(view),
        corners_(corners),
        config_(config),
        key_(key),
        centre_m_(centre_m),
        sums_(static_cast<std::size_t>(view.camera.width_px)) {}

  void operator()(int y, InfraredImage& out, Image<SkyPixel>& sky) {
    sky_ = sky.row(y).data();
    const int width = view_.camera.width_px;
    const int side = static_cast<int>(std::lround(std::sqrt(config_.pixel_samples)));
    const Pose camera_from_world = pose_at_row(view_, y);
    const Eigen::Matrix3f world_from_camera =
        camera_from_world.rotation.conjugate().toRotationMatrix().cast<float>();
    samples_.origin_m = (centre_in_world_m(camera_from_world) - centre_m_).cast<float>();
    std::fill(sums_.begin(), sums_.end(), InfraredSum{});
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
        // Not drawn at random: a random place in a quarter of a pixel sees a dot's flank by chance.
        const double u = (k % side + 0.5) / side, v = (k / side + 0.5) / side;
        const Eigen::Vector3d d =
            (above[0] * (1 - u) + above[1] * u) * (1 - v) + (below[0] * (1 - u) + below[1] * u) * v;
        samples_.direction[lane] = world_from_camera * d.normalized().cast<float>();
        samples_.mask.lane[lane] = -1;
        column_[lane] = x;
        draw_ways(lane, x, y, k, ~hash);
        if (++lane == kLanes) flush(lane, y);
      }
    }
    if (lane > 0) flush(lane, y);
    for (int x = 0; x < width; ++x) {
      const InfraredSum& sum = sums_[static_cast<std::size_t>(x)];
      const auto count = static_cast<float>(std::max(sum.count, 1));
      out.radiance(x, y) = (sum.steady + sum.gain * sum.projected) / count;
      out.projected(x, y) =
          sum.met > 0 ? static_cast<float>(sum.lit) / static_cast<float>(sum.met) : 0.0F;
    }
  }

 private:
  /// Directions of a sample's shadow rays: the sky's are a part of a pattern that the tile shares.
  void draw_ways(int lane, int x, int y, int k, std::uint64_t hash) {
    const int tile = y % kSkyTile_px * kSkyTile_px + x % kSkyTile_px;
    const auto index = static_cast<std::uint32_t>(tile * config_.pixel_samples + k);
    samples_.sky[lane] = rotated(sobol_point(index), unit_pair(hash64(key_)));
    samples_.lamp[lane] = unit_pair(hash64(hash + static_cast<std::uint64_t>(k)));
  }

  std::uint64_t pixel_hash(int x, int y) const {
    return hash64(key_ + (static_cast<std::uint64_t>(y) << 32) + static_cast<std::uint64_t>(x));
  }

  void flush(int& lanes, int y) {
    for (int i = lanes; i < kLanes; ++i) samples_.mask.lane[i] = 0;
    shade_(samples_);
    for (int i = 0; i < lanes; ++i) {
      InfraredSum& sum = sums_[static_cast<std::size_t>(column_[i])];
      if (sum.met == 0 && samples_.met[i] && config_.speckle_contrast > 0)
        sum.gain = gain_at(samples_.hit[i], column_[i], y);
      SkyPixel& sky = sky_[column_[i]];
      if (sum.met == 0 && samples_.met[i]) {
        const InfraredHit& hit = samples_.hit[i];
        sky.surface = hit.surface;
        sky.normal = hit.normal;
        sky.distance_m = (hit.position_m - samples_.origin_m).norm();
      }
      sky.ambient += samples_.ambient[i];
      sky.asked += samples_.asked[i];
      sky.open += samples_.open[i];
      sum.steady += samples_.steady[i];
      sum.projected += samples_.projected[i];
      sum.met += samples_.met[i] ? 1 : 0;
      sum.lit += samples_.projected[i] > 0 ? 1 : 0;
      ++sum.count;
    }
    lanes = 0;
  }

  float gain_at(const InfraredHit& hit, int x, int y) const {
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

  InfraredShader shade_;
  const TrueView& view_;
  const std::vector<Eigen::Vector3d>& corners_;
  const InfraredConfig& config_;
  std::uint64_t key_;
  Eigen::Vector3d centre_m_;
  std::vector<InfraredSum> sums_;
  SkyPixel* sky_ = nullptr;
  InfraredSamples samples_;
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
  const double sample_rad = 1 / (view.camera.fx_px * std::sqrt(config.pixel_samples));
  const InfraredLights lights =
      make_infrared_lights(scene, projectors, config, impl.centre_m, sample_rad);
  const auto surfaces = make_infrared_surfaces(scene, impl.span_s.begin_s, impl.centre_m);
  const auto corners = lens_directions(view.camera, -0.5, -0.5, width + 1, height + 1, 1e-4);
  const std::uint64_t key = rng.fork("infrared")();
  InfraredImage image{Image<float>(width, height), Image<float>(width, height)};
  Image<SkyPixel> sky(width, height);
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 8), [&](const auto& range) {
    const FlushDenormals flush;
    RowRenderer render(InfraredShader(impl, lights, surfaces), view, corners, config, key,
                       impl.centre_m);
    for (int y = range.begin(); y < range.end(); ++y) render(y, image, sky);
  });
  // A pixel's sum is over all of its samples: those that met nothing count.
  const auto samples = static_cast<float>(config.pixel_samples);
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 8), [&](const auto& range) {
    for (int y = range.begin(); y < range.end(); ++y) {
      for (int x = 0; x < width; ++x) {
        const float ambient = sky(x, y).ambient;
        if (ambient > 0) image.radiance(x, y) += ambient / samples * open_sky(sky, x, y);
      }
    }
  });
  return image;
}

}  // namespace cousin
