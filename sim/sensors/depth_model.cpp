#include "sim/sensors/depth_model.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include "sim/config/limits.h"
#include "sim/sensors/active_stereo.h"
#include "sim/sensors/fast_normal.h"
#include "sim/sensors/noise_grain.h"

namespace cousin {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

/// Linear between knots, constant beyond: a table over log2 of the SNR.
float at_knots(const std::vector<double>& x, const std::vector<double>& y, float at) {
  const auto value = static_cast<double>(at);
  if (!(value > x.front())) return static_cast<float>(y.front());
  if (value >= x.back()) return static_cast<float>(y.back());
  std::size_t i = 1;
  while (x[i] < value) ++i;
  const double t = (value - x[i - 1]) / (x[i] - x[i - 1]);
  return static_cast<float>(y[i - 1] * (1 - t) + y[i] * t);
}

/// A table at steps of 1/16 in the logarithm, for speed.
class Curve {
 public:
  Curve(const std::vector<double>& x, const std::vector<double>& y)
      : first_(static_cast<float>(x.front())) {
    const int steps = std::max(1, static_cast<int>(std::ceil((x.back() - x.front()) * 16)));
    for (int i = 0; i <= steps; ++i)
      values_.push_back(at_knots(x, y, first_ + static_cast<float>(i) / 16));
  }
  float operator()(float log2_snr) const {
    const float p = (log2_snr - first_) * 16;
    if (!(p > 0)) return values_.front();
    const auto i = static_cast<std::size_t>(p);
    if (i + 1 >= values_.size()) return values_.back();
    const float t = p - static_cast<float>(i);
    return values_[i] * (1 - t) + values_[i + 1] * t;
  }

 private:
  float first_;
  std::vector<float> values_;
};

/// Near surfaces grow: a pixel takes the largest disparity within the radius, if that is a jump.
Image<float> fattened(const Image<float>& disparity_px, int radius) {
  constexpr float kJump_px = 2;
  if (radius <= 0) return disparity_px;
  const int width = disparity_px.width(), height = disparity_px.height();
  Image<float> across(width, height), result(width, height);
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 16), [&](const auto& range) {
    for (int y = range.begin(); y < range.end(); ++y) {
      const float* row = disparity_px.row(y).data();
      float* out = across.row(y).data();
      std::copy(row, row + width, out);
      for (int k = 1; k <= radius; ++k) {
        for (int x = k; x < width; ++x) out[x] = std::max(out[x], row[x - k]);
        for (int x = 0; x < width - k; ++x) out[x] = std::max(out[x], row[x + k]);
      }
    }
  });
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 16), [&](const auto& range) {
    std::vector<float> most(static_cast<std::size_t>(width));
    for (int y = range.begin(); y < range.end(); ++y) {
      std::fill(most.begin(), most.end(), 0.0F);
      for (int j = std::max(y - radius, 0); j <= std::min(y + radius, height - 1); ++j) {
        const float* row = across.row(j).data();
        for (std::size_t x = 0; x < most.size(); ++x) most[x] = std::max(most[x], row[x]);
      }
      const float* own = disparity_px.row(y).data();
      float* out = result.row(y).data();
      for (std::size_t x = 0; x < most.size(); ++x)
        out[x] = most[x] > own[x] + kJump_px ? most[x] : own[x];
    }
  });
  return result;
}

/// Fields of noise of one image, unit variance each.
struct NoiseFields {
  Image<float> spatial, temporal, hole;
};
NoiseFields make_fields(int width, int height, const DepthModelConfig& model, const Rng& fixed,
                        const Rng& frame) {
  NoiseFields fields;
  tbb::parallel_invoke(
      [&] { fields.spatial = noise_grain(width, height, model.grain_px, fixed.fork("spatial")); },
      [&] { fields.temporal = noise_grain(width, height, model.grain_px, frame.fork("temporal")); },
      [&] { fields.hole = noise_grain(width, height, model.grain_px, fixed.fork("holes")); });
  return fields;
}

/// The model of each pixel of one image.
class PixelModel {
 public:
  PixelModel(const DepthModelInputs& inputs, const ActiveStereoConfig& config, const Camera& camera,
             const Rng& fixed, const Rng& frame)
      : inputs_(inputs),
        model_(config.model),
        camera_(camera),
        truth_px_(disparities(inputs.depth_m, camera.fx_px * config.baseline_m)),
        near_px_(fattened(truth_px_, static_cast<int>(std::lround(model_.fatten_px)))),
        rim_px_(fattened(near_px_, static_cast<int>(std::lround(model_.rim_px)))),
        snr_(pattern_snr(pattern_light(inputs, config), model_.margin_weight)),
        noise_(make_fields(camera.width_px, camera.height_px, model_, fixed, frame)),
        spatial_(model_.log2_snr, model_.spatial_px),
        temporal_(model_.log2_snr, model_.temporal_px),
        fill_(model_.log2_snr, model_.fill),
        step_(static_cast<float>(config.disparity_step_px)),
        most_(static_cast<float>(config.match.shift_px + config.match.range_px)),
        least_(
            static_cast<float>(std::max(camera.fx_px * config.baseline_m / config.largest_depth_m,
                                        config.match.shift_px + 0.5))) {}

  InvalidReason operator()(int x, int y, float& disparity_px) const {
    const float d = near_px_(x, y);
    if (d < least_ || d > most_) return InvalidReason::out_of_range;
    if (static_cast<float>(x) - d < static_cast<float>(model_.band_px)) return InvalidReason::band;
    const bool is_own = d == truth_px_(x, y);
    const std::uint8_t hidden = is_own ? inputs_.hidden(x, y) : std::uint8_t{0};
    if (hidden & kHiddenFromRight) return InvalidReason::left_right;
    if (rim_px_(x, y) != d) return InvalidReason::mixed_pixel;
    const float slope = slope_at(x, y, d);
    const float log2_snr = snr_(x, y) > 0 ? std::log2(snr_(x, y)) : -100;
    const float filled =
        fill_(log2_snr) * std::max(0.0F, 1 - static_cast<float>(model_.slope_loss) * slope * slope);
    if (normal_share(noise_.hole(x, y)) > filled || filled == 0) {
      return (hidden & kHiddenFromProjector) ? InvalidReason::no_projector
                                             : InvalidReason::no_texture;
    }
    const float found = d + error_px(x, y, d, slope, log2_snr);
    const float quantised = step_ > 0 ? std::round(found / step_) * step_ : found;
    if (quantised < least_ || quantised > most_) return InvalidReason::out_of_range;
    disparity_px = quantised;
    return InvalidReason::none;
  }

 private:
  static Image<float> disparities(const Image<float>& depth_m, double focal_baseline) {
    Image<float> result(depth_m.width(), depth_m.height());
    std::transform(depth_m.begin(), depth_m.end(), result.begin(),
                   [&](float z) { return z > 0 ? static_cast<float>(focal_baseline) / z : 0; });
    return result;
  }

  /// |grad d| of the surface's plane: n . r(x, y) d = constant, r = the pixel's ray at depth 1.
  float slope_at(int x, int y, float d) const {
    const Eigen::Vector3f& n = inputs_.normal(x, y);
    const auto f = static_cast<float>(camera_.fx_px);
    const float along = n.x() * (static_cast<float>(x) - static_cast<float>(camera_.cx_px)) / f +
                        n.y() * (static_cast<float>(y) - static_cast<float>(camera_.cy_px)) / f +
                        n.z();
    if (along == 0) return 1;
    return std::min(1.0F, d / f * std::sqrt(n.x() * n.x() + n.y() * n.y()) / std::abs(along));
  }

  float error_px(int x, int y, float d, float slope, float log2_snr) const {
    const float flat = spatial_(log2_snr),
                tilted = static_cast<float>(model_.slope_noise) * slope * slope;
    return static_cast<float>(model_.bias_px) +
           static_cast<float>(model_.ripple_px) *
               std::sin(2 * std::numbers::pi_v<float> * (d - std::floor(d))) +
           std::sqrt(flat * flat + tilted * tilted) * noise_.spatial(x, y) +
           temporal_(log2_snr) * noise_.temporal(x, y);
  }

  const DepthModelInputs& inputs_;
  const DepthModelConfig& model_;
  const Camera& camera_;
  Image<float> truth_px_, near_px_, rim_px_, snr_;
  NoiseFields noise_;
  Curve spatial_, temporal_, fill_;
  float step_, most_, least_;
};

}  // namespace

Fields fields(DepthModelConfig& c) {
  return {
      {"log2_snr", &c.log2_snr, "knots: log2 of the pattern's SNR", -40, 40},
      {"spatial_px", &c.spatial_px, "sigma of the fixed noise at the knots", 0, 100},
      {"temporal_px", &c.temporal_px, "sigma of each image's noise at the knots", 0, 100},
      {"fill", &c.fill, "share of pixels with a depth at the knots", 0, 1},
      {"margin_weight", &c.margin_weight, "of the matcher's margin among the noise", 0, 100},
      {"slope_noise", &c.slope_noise, "spatial sigma at a disparity slope of 1", 0, 100},
      {"slope_loss", &c.slope_loss, "share of fill lost at a disparity slope of 1", 0, 100},
      {"ripple_px", &c.ripple_px, "amplitude of d + A sin(2 pi d)", -1, 1},
      {"bias_px", &c.bias_px, "mean error of the disparity", -10, 10},
      {"fatten_px", &c.fatten_px, "growth of near surfaces", 0, 32},
      {"rim_px", &c.rim_px, "width of what has no depth beside near surfaces", 0, 32},
      {"band_px", &c.band_px, "the left band beyond the disparity", -64, 64},
      {"grain_px", &c.grain_px, "width over which noise is alike", 1, 65},
  };
}

void validate(const DepthModelConfig& config) {
  DepthModelConfig copy = config;
  check_limits(fields(copy), "depth model");
  const std::size_t n = config.log2_snr.size();
  if (n < 2 || config.spatial_px.size() != n || config.temporal_px.size() != n ||
      config.fill.size() != n) {
    throw std::invalid_argument(
        "depth model: log2_snr, spatial_px, temporal_px and fill have " + std::to_string(n) + ", " +
        std::to_string(config.spatial_px.size()) + ", " +
        std::to_string(config.temporal_px.size()) + " and " + std::to_string(config.fill.size()) +
        " numbers; they must be as many, at least 2");
  }
  for (std::size_t i = 1; i < n; ++i) {
    if (!(config.log2_snr[i] > config.log2_snr[i - 1]))
      throw std::invalid_argument("depth model: log2_snr must increase");
  }
}

ModelDepth model_depth(const DepthModelInputs& inputs, const ActiveStereoConfig& config,
                       const Rng& fixed, const Rng& frame) {
  validate(config.model);
  const Camera camera = depth_camera(config);
  validate(inputs, camera);
  const int width = camera.width_px, height = camera.height_px;
  const PixelModel model(inputs, config, camera, fixed, frame);
  ModelDepth out{Image<float>(width, height, kNone), {}, Image<InvalidReason>(width, height)};
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 16), [&](const auto& range) {
    for (int y = range.begin(); y < range.end(); ++y) {
      for (int x = 0; x < width; ++x) out.reason(x, y) = model(x, y, out.disparity_px(x, y));
    }
  });
  out.depth = depth_of_disparity(out.disparity_px, config);
  return out;
}

}  // namespace cousin
