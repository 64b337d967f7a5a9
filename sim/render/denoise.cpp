#include "sim/render/denoise.h"

#include <tbb/parallel_for.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

namespace cousin {
namespace {

constexpr int kBand = 16;        ///< rows that one task averages
constexpr int kPatch = 1;        ///< radius of the patches whose colours are compared
constexpr float kTiny = 1e-12F;  ///< added to squared radiances

/// Variance of each pixel's luminance, averaged over 3 x 3 pixels: of few samples, one pixel's own
/// estimate is often far too small.
Image<float> smooth_variance(const Image<float>& error) {
  Image<float> variance(error.width(), error.height());
  tbb::parallel_for(0, error.height(), [&](int y) {
    for (int x = 0; x < error.width(); ++x) {
      float sum = 0;
      int count = 0;
      for (int v = std::max(y - 1, 0); v <= std::min(y + 1, error.height() - 1); ++v) {
        for (int u = std::max(x - 1, 0); u <= std::min(x + 1, error.width() - 1); ++u) {
          sum += error(u, v) * error(u, v);
          ++count;
        }
      }
      variance(x, y) = sum / static_cast<float>(count);
    }
  });
  return variance;
}

/// Everything a pair of pixels is compared by.
struct Guide {
  const PathImage& noisy;
  const TruthImages& truth;
  Image<float> variance;
  float inverse_focal = 0;  ///< metres per pixel at depth 1
  float color_scale = 0, normal_scale = 0, plane_scale = 0;

  bool contains(int x, int y) const { return noisy.radiance.contains(x, y); }

  /// Squared difference of two pixels' colours over what their noise explains, less what it does.
  float color_distance(int x, int y, int u, int v) const {
    const Rgbf &p = noisy.radiance(x, y), &q = noisy.radiance(u, v);
    const float a = variance(x, y), b = variance(u, v);
    const float dr = p.r - q.r, dg = p.g - q.g, db = p.b - q.b;
    const float squared = (dr * dr + dg * dg + db * db) / 3;
    return (squared - (a + std::min(a, b))) / (kTiny + color_scale * (a + b));
  }

  /// 0 (the same surface) upwards.
  float surface_distance(int x, int y, int u, int v) const {
    const float z = truth.depth_m(x, y);
    const bool here = std::isfinite(z), there = std::isfinite(truth.depth_m(u, v));
    if (here != there) return 1e6F;
    if (!here) return 0;
    const float turn = 1 - truth.normal(x, y).dot(truth.normal(u, v));
    const Eigen::Vector3f step = truth.position_m(u, v) - truth.position_m(x, y);
    const float off = world_normal(x, y).dot(step) / (z * inverse_focal);
    return turn * normal_scale + off * off * plane_scale;
  }

  Eigen::Matrix3f world_from_camera;
  Eigen::Vector3f world_normal(int x, int y) const {
    return world_from_camera * truth.normal(x, y);
  }
};

/// Sums of a band of rows while offset after offset is added.
class Band {
 public:
  Band(const Guide& guide, int y0, int y1)
      : guide_(guide),
        width_(guide.noisy.radiance.width()),
        y0_(y0),
        y1_(y1),
        distance_(static_cast<std::size_t>(width_) *
                  static_cast<std::size_t>(y1 - y0 + 2 * kPatch)),
        sum_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(y1 - y0),
             Eigen::Vector4f::Zero()) {}

  void add_offset(int dx, int dy) {
    for (int y = y0_ - kPatch; y < y1_ + kPatch; ++y) {
      for (int x = 0; x < width_; ++x) {
        const bool both = guide_.contains(x, y) && guide_.contains(x + dx, y + dy);
        distance_[at(x, y - y0_ + kPatch)] =
            both ? guide_.color_distance(x, y, x + dx, y + dy) : kOutside;
      }
    }
    for (int y = y0_; y < y1_; ++y) {
      for (int x = 0; x < width_; ++x) {
        if (!guide_.contains(x + dx, y + dy)) continue;
        const float d = std::max(0.0F, patch_distance(x, y - y0_ + kPatch)) +
                        guide_.surface_distance(x, y, x + dx, y + dy);
        if (d > 12) continue;
        const Rgbf& q = guide_.noisy.radiance(x + dx, y + dy);
        sum_[at(x, y - y0_)] += std::exp(-d) * Eigen::Vector4f(q.r, q.g, q.b, 1);
      }
    }
  }

  void write(Image<Rgbf>& out) const {
    for (int y = y0_; y < y1_; ++y) {
      for (int x = 0; x < width_; ++x) {
        const Eigen::Vector4f& s = sum_[at(x, y - y0_)];
        const bool keep = guide_.variance(x, y) == 0 || !(s.w() > 0);
        out(x, y) =
            keep ? guide_.noisy.radiance(x, y) : Rgbf{s.x() / s.w(), s.y() / s.w(), s.z() / s.w()};
      }
    }
  }

 private:
  static constexpr float kOutside = -1e30F;  ///< patch pixels outside the image do not count
  std::size_t at(int x, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(x);
  }
  float patch_distance(int x, int row) const {
    float sum = 0;
    int count = 0;
    for (int v = row - kPatch; v <= row + kPatch; ++v) {
      for (int u = std::max(x - kPatch, 0); u <= std::min(x + kPatch, width_ - 1); ++u) {
        const float d = distance_[at(u, v)];
        if (d == kOutside) continue;
        sum += d;
        ++count;
      }
    }
    return sum / static_cast<float>(std::max(count, 1));
  }

  const Guide& guide_;
  int width_, y0_, y1_;
  std::vector<float> distance_;
  std::vector<Eigen::Vector4f> sum_;  ///< r, g, b and weight
};

[[noreturn]] void fail_denoise(const char* field, double value, const char* limit) {
  throw std::invalid_argument("denoise: " + std::string(field) + " = " + std::to_string(value) +
                              " " + limit);
}

void require_size(const char* what, int width, int height, const Image<Rgbf>& noisy) {
  if (width == noisy.width() && height == noisy.height()) return;
  throw std::invalid_argument("denoise: " + std::string(what) + " is " + std::to_string(width) +
                              " x " + std::to_string(height) + " px, the radiance " +
                              std::to_string(noisy.width()) + " x " +
                              std::to_string(noisy.height()));
}

}  // namespace

Fields fields(DenoiseConfig& config) {
  return {
      {"radius_px", &config.radius_px, "of the window whose pixels are averaged", 1, 32},
      {"color_sigmas", &config.color_sigmas, "standard deviations that colours may differ by", 0.01,
       10},
      {"normal_degrees", &config.normal_degrees, "angle at which a weight falls to 1 / e", 0.1, 90},
      {"distance_px", &config.distance_px, "off the tangent plane, in widths of a pixel", 0.01,
       1000},
  };
}

void validate(const DenoiseConfig& config) {
  if (config.radius_px < 1 || config.radius_px > 32)
    fail_denoise("radius_px", config.radius_px, "is not in 1..32");
  if (!(config.color_sigmas >= 0.01 && config.color_sigmas <= 10))
    fail_denoise("color_sigmas", config.color_sigmas, "is not in [0.01, 10]");
  if (!(config.normal_degrees >= 0.1 && config.normal_degrees <= 90))
    fail_denoise("normal_degrees", config.normal_degrees, "is not in [0.1, 90]");
  if (!(config.distance_px >= 0.01 && config.distance_px <= 1000))
    fail_denoise("distance_px", config.distance_px, "is not in [0.01, 1000]");
}

Image<Rgbf> denoise(const PathImage& noisy, const TrueView& view, const TruthImages& guide,
                    const DenoiseConfig& config) {
  validate(config);
  const int width = noisy.radiance.width(), height = noisy.radiance.height();
  require_size("the error image", noisy.luminance_error.width(), noisy.luminance_error.height(),
               noisy.radiance);
  require_size("the depth image", guide.depth_m.width(), guide.depth_m.height(), noisy.radiance);
  require_size("the normal image", guide.normal.width(), guide.normal.height(), noisy.radiance);
  require_size("the position image", guide.position_m.width(), guide.position_m.height(),
               noisy.radiance);
  const auto squared = [](double x) { return static_cast<float>(x * x); };
  const Guide g{
      noisy,
      guide,
      smooth_variance(noisy.luminance_error),
      1 / static_cast<float>(view.camera.fx_px),
      squared(config.color_sigmas),
      static_cast<float>(1 / (1 - std::cos(config.normal_degrees * std::numbers::pi / 180))),
      1 / squared(config.distance_px),
      view.camera_from_world.rotation.toRotationMatrix().transpose().cast<float>()};
  Image<Rgbf> out(width, height);
  tbb::parallel_for(0, (height + kBand - 1) / kBand, [&](int i) {
    Band band(g, i * kBand, std::min((i + 1) * kBand, height));
    for (int dy = -config.radius_px; dy <= config.radius_px; ++dy) {
      for (int dx = -config.radius_px; dx <= config.radius_px; ++dx) band.add_offset(dx, dy);
    }
    band.write(out);
  });
  return out;
}

}  // namespace cousin
