#include "sim/render/path_tracer.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/render/path_batch.h"
#include "sim/render/pixel_rays.h"
#include "sim/truth/scene_check.h"

namespace cousin {
namespace {

using Eigen::Vector3f;

constexpr int kTile = 16;           ///< pixels along a tile's side
constexpr int kBatch = 4096;        ///< samples that travel together
constexpr int kInstants = 8;        ///< poses a row while the camera moves
constexpr int kBlock = 4;           ///< samples whose mean is one draw of the error estimate
constexpr double kMostOfMean = 32;  ///< no pixel gets more than so many times the mean

/// What a pixel has gathered.
struct PixelSum {
  Vector3f sum = Vector3f::Zero();
  std::uint32_t count = 0;
  // Luminance by blocks of kBlock samples: a block is stratified, so its mean varies less than a
  // quarter of a sample does.
  float block = 0;
  double block_sum = 0, block_sum2 = 0;

  void add(const Vector3f& radiance) {
    sum += radiance;
    block += 0.2126F * radiance.x() + 0.7152F * radiance.y() + 0.0722F * radiance.z();
    if (++count % kBlock != 0) return;
    const double mean = static_cast<double>(block) / kBlock;
    block_sum += mean;
    block_sum2 += mean * mean;
    block = 0;
  }
  double luminance() const {
    const Vector3f m = sum / static_cast<float>(std::max(count, 1U));
    return 0.2126 * static_cast<double>(m.x()) + 0.7152 * static_cast<double>(m.y()) +
           0.0722 * static_cast<double>(m.z());
  }
  /// Variance of one block's mean; 0 below two blocks.
  double block_variance() const {
    const double n = count / kBlock;
    if (n < 2) return 0;
    return std::max(0.0, (block_sum2 - block_sum * block_sum / n) / (n - 1));
  }
};

/// One view while it is rendered.
class ViewRenderer {
 public:
  ViewRenderer(const PathTracer::Impl& scene, const TrueView& view, const PathConfig& config,
               const Rng& rng)
      : scene_(scene),
        view_(view),
        config_(config),
        width_(view.camera.width_px),
        height_(view.camera.height_px),
        instants_(is_moving(view) ? kInstants : 1),
        has_motion_(scene.rays->span_s.end_s > scene.rays->span_s.begin_s),
        rays_(view, scene.rays->centre_m, instants_),
        key_(rng.fork("paths")()),
        sums_(width_, height_) {}

  /// Brings every pixel to its number of samples.
  template <class Target>  // int(int x, int y)
  void sample_to(const Target& target) {
    const int columns = (width_ + kTile - 1) / kTile, rows = (height_ + kTile - 1) / kTile;
    tbb::parallel_for(0, columns * rows, [&](int tile) {
      const FlushDenormals flush;
      PathBatch batch(scene_, config_);
      const int x0 = tile % columns * kTile, y0 = tile / columns * kTile;
      sample_tile(batch, x0, y0, target);
      traced_ += batch.rays();
    });
  }

  /// Samples a pixel for a mean of `mean` samples, in proportion to its relative error; never less
  /// than it has.
  Image<int> spread(double mean) const {
    const Image<float> want = wanted_share();
    double low = 0, high = 1;
    const auto total = [&](double scale) {
      double sum = 0;
      for (std::size_t i = 0; i < want.size(); ++i) sum += pixel_target(want, i, scale, mean);
      return sum;
    };
    const double budget = mean * static_cast<double>(want.size());
    while (total(high) < budget && high < 1e12) high *= 2;
    for (int i = 0; i < 50; ++i) {
      const double middle = 0.5 * (low + high);
      (total(middle) < budget ? low : high) = middle;
    }
    Image<int> target(width_, height_);
    for (std::size_t i = 0; i < want.size(); ++i) {
      // Whole blocks; what it has stays.
      const double n = pixel_target(want, i, low, mean);
      const auto has = static_cast<int>(sums_.data()[i].count);
      target.data()[i] = std::max(has, static_cast<int>(n) / kBlock * kBlock);
    }
    return target;
  }

  /// Root of the mean over pixels of (standard error / (luminance + a tenth of the mean))^2.
  double relative_error() const {
    const double floor = 0.1 * mean_luminance();
    double sum = 0;
    for (const PixelSum& p : sums_) {
      const double blocks = std::max<double>(p.count / kBlock, 1);
      const double scale = p.luminance() + floor;
      if (scale > 0) sum += p.block_variance() / blocks / (scale * scale);
    }
    return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(sums_.size(), 1)));
  }

  PathImage image() const {
    PathImage out;
    out.radiance = Image<Rgbf>(width_, height_);
    out.luminance_error = Image<float>(width_, height_);
    out.samples = Image<std::uint32_t>(width_, height_);
    for (std::size_t i = 0; i < sums_.size(); ++i) {
      const PixelSum& p = sums_.data()[i];
      const Vector3f m = p.sum / static_cast<float>(std::max(p.count, 1U));
      out.radiance.data()[i] = {m.x(), m.y(), m.z()};
      const double blocks = std::max<double>(p.count / kBlock, 1);
      out.luminance_error.data()[i] = static_cast<float>(std::sqrt(p.block_variance() / blocks));
      out.samples.data()[i] = p.count;
    }
    out.rays = traced_;
    return out;
  }

 private:
  static bool is_moving(const TrueView& view) {
    const Pose& a = view.camera_from_world;
    const Pose& b = view.camera_from_world_end;
    return view.exposure_s > 0 &&
           (a.translation_m != b.translation_m || a.rotation.coeffs() != b.rotation.coeffs());
  }

  double mean_luminance() const {
    double sum = 0;
    for (const PixelSum& p : sums_) sum += p.luminance();
    return sum / static_cast<double>(std::max<std::size_t>(sums_.size(), 1));
  }

  /// Standard deviation over brightness for each pixel, variances averaged over 3 x 3 pixels so
  /// that a pixel's own draw hardly decides.
  Image<float> wanted_share() const {
    const double floor = 0.1 * mean_luminance();
    Image<float> want(width_, height_);
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        double variance = 0, brightness = 0;
        int count = 0;
        for (int v = std::max(y - 1, 0); v <= std::min(y + 1, height_ - 1); ++v) {
          for (int u = std::max(x - 1, 0); u <= std::min(x + 1, width_ - 1); ++u) {
            variance += sums_(u, v).block_variance();
            brightness += sums_(u, v).luminance();
            ++count;
          }
        }
        const double scale = brightness / count + floor;
        want(x, y) = scale > 0 ? static_cast<float>(std::sqrt(variance / count) / scale) : 0;
      }
    }
    return want;
  }

  double pixel_target(const Image<float>& want, std::size_t i, double scale, double mean) const {
    const double n =
        std::min(scale * mean * static_cast<double>(want.data()[i]), kMostOfMean * mean);
    return std::max(n, static_cast<double>(sums_.data()[i].count));
  }

  template <class Target>
  void sample_tile(PathBatch& batch, int x0, int y0, const Target& target) {
    const int x1 = std::min(x0 + kTile, width_), y1 = std::min(y0 + kTile, height_);
    std::vector<PixelSum*> owners;
    const auto flush = [&] {
      batch.run();
      for (std::size_t i = 0; i < owners.size(); ++i) owners[i]->add(batch.radiance(i));
      owners.clear();
      batch.clear();
    };
    batch.clear();
    // Sixteen samples of a pixel make a packet of rays that stay together.
    for (bool more = true; more;) {
      more = false;
      for (int y = y0; y < y1; ++y) {
        for (int x = x0; x < x1; ++x) {
          PixelSum& pixel = sums_(x, y);
          const std::uint32_t first = pixel.count;
          const auto last = static_cast<std::uint32_t>(target(x, y));
          const std::uint32_t end = std::min(first + kLanes, last);
          for (std::uint32_t s = first; s < end; ++s) {
            add_camera_ray(batch, x, y, s);
            owners.push_back(&pixel);
          }
          more = more || end < last;
          if (owners.size() + kLanes > kBatch) flush();
        }
      }
      if (!owners.empty()) flush();
    }
  }

  void add_camera_ray(PathBatch& batch, int x, int y, std::uint32_t sample) const {
    const std::uint64_t pixel = static_cast<std::uint64_t>(y) << 32 | static_cast<std::uint32_t>(x);
    const PathSampler sampler{hash64(key_ ^ hash64(pixel)), sample};
    const Vector3f in_camera = rays_.in_camera(x, y, sampler.pair(0));
    const float share = sampler.pair(2).x();  // of the row's exposure
    const int instant =
        instants_ == 1 ? 0 : static_cast<int>(share * static_cast<float>(instants_));
    const float time =
        has_motion_
            ? ray_time(*scene_.rays, time_in_exposure_s(view_, y, static_cast<double>(share)))
            : 0;
    const auto& row = rays_.row(y, instant);
    if (!(view_.aperture_radius_m > 0) || !std::isfinite(view_.focus_m) || in_camera.z() <= 1e-6F) {
      batch.add(row.origin_m, row.world_from_camera * in_camera, sampler, time);
      return;
    }
    // Thin lens: through a point of the aperture to where the pinhole's ray meets the sharp plane.
    const Eigen::Vector2f disk =
        static_cast<float>(view_.aperture_radius_m) * concentric_disk(sampler.pair(1));
    const Vector3f on_lens(disk.x(), disk.y(), 0);
    const Vector3f sharp = in_camera * (static_cast<float>(view_.focus_m) / in_camera.z());
    batch.add(row.origin_m + row.world_from_camera * on_lens,
              row.world_from_camera * (sharp - on_lens).normalized(), sampler, time);
  }

  const PathTracer::Impl& scene_;
  const TrueView& view_;
  const PathConfig& config_;
  int width_, height_, instants_;
  bool has_motion_;
  PixelRays rays_;
  std::uint64_t key_;
  Image<PixelSum> sums_;
  std::atomic<std::uint64_t> traced_{0};
};

[[noreturn]] void fail(const char* field, double value, const char* limit) {
  throw std::invalid_argument("path tracer: " + std::string(field) + " = " + std::to_string(value) +
                              " " + limit);
}

}  // namespace

Fields fields(PathConfig& config) {
  return {
      {"pixel_samples", &config.pixel_samples, "camera rays a pixel; adaptive: on average", 1,
       1 << 20},
      {"max_bounces", &config.max_bounces, "surfaces after the first; 0 = direct light only", 0,
       1024},
      {"adaptive", &config.adaptive, "more samples where the relative error is larger"},
      {"min_samples", &config.min_samples, "a pixel, before samples are spread by error", 8,
       1 << 20},
      {"target_error", &config.target_error, "adaptive: stop at this relative error; 0 = never", 0,
       1},
      {"refracts_sun", &config.refracts_sun,
       "suns and beams through water: refracted, right and noisy; false = straight"},
  };
}

void validate(const PathConfig& config) {
  if (config.pixel_samples < 1 || config.pixel_samples > 1 << 20)
    fail("pixel_samples", config.pixel_samples, "is not in 1..1048576");
  if (config.max_bounces < 0 || config.max_bounces > 1024)
    fail("max_bounces", config.max_bounces, "is not in 0..1024");
  if (config.min_samples < 2 * kBlock || config.min_samples > 1 << 20)
    fail("min_samples", config.min_samples, "is not in 8..1048576");
  if (!(config.target_error >= 0 && config.target_error <= 1))
    fail("target_error", config.target_error, "is not in [0, 1]");
}

PathImage PathTracer::render(const TrueView& view, const PathConfig& config, Rng rng) const {
  validate(config);
  validate(view);
  ViewRenderer renderer(*impl_, view, config, rng);
  if (!config.adaptive) {
    renderer.sample_to([&](int, int) { return config.pixel_samples; });
    return renderer.image();
  }
  const int first = std::min(config.min_samples, config.pixel_samples);
  renderer.sample_to([&](int, int) { return first; });
  // The mean doubles from round to round, so that most samples follow a good estimate.
  for (double mean = first; mean < config.pixel_samples;) {
    if (config.target_error > 0 && renderer.relative_error() <= config.target_error) break;
    mean = std::min(2 * mean, static_cast<double>(config.pixel_samples));
    const Image<int> target = renderer.spread(mean);
    renderer.sample_to([&](int x, int y) { return target(x, y); });
  }
  return renderer.image();
}

}  // namespace cousin
