#include "sim/sensors/depth_model.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include "sim/config/limits.h"
#include "sim/sensors/active_stereo.h"
#include "sim/sensors/fast_normal.h"
#include "sim/sensors/match_contrast.h"
#include "sim/sensors/noise_grain.h"
#include "sim/types/no_value.h"

namespace cousin {
namespace {

/// The model's curves as a table at steps of 1/32 of the contrast, for speed.
class Curves {
 public:
  struct Values {
    float score, score_wave, spatial, spatial_wave, temporal, temporal_wave, ripple;
  };
  explicit Curves(const DepthModelConfig& model)
      : first_(static_cast<float>(model.contrast.front())) {
    const std::vector<double>& x = model.contrast;
    const int steps = std::max(1, static_cast<int>(std::ceil((x.back() - x.front()) * kSteps)));
    for (int i = 0; i <= steps; ++i) {
      const auto at = [&](const std::vector<double>& curve) {
        return static_cast<float>(at_knots(x, curve, x.front() + i / static_cast<double>(kSteps)));
      };
      table_.push_back({at(model.fill_score), at(model.fill_wave), at(model.spatial_px),
                        at(model.spatial_wave), at(model.temporal_px), at(model.temporal_wave),
                        at(model.ripple_px)});
    }
  }
  Values operator()(float contrast) const {
    const float p = (contrast - first_) * kSteps;
    if (!(p > 0)) return table_.front();
    if (!(p < static_cast<float>(table_.size() - 1))) return table_.back();
    const auto i = static_cast<std::size_t>(p);
    const float t = p - static_cast<float>(i);
    const Values &a = table_[i], &b = table_[i + 1];
    const auto mix = [&](float Values::*part) { return a.*part * (1 - t) + b.*part * t; };
    return {mix(&Values::score),        mix(&Values::score_wave), mix(&Values::spatial),
            mix(&Values::spatial_wave), mix(&Values::temporal),   mix(&Values::temporal_wave),
            mix(&Values::ripple)};
  }

 private:
  static constexpr int kSteps = 32;
  float first_;
  std::vector<Values> table_;
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
        light_(pattern_light(inputs, config)),
        noise_(make_fields(camera.width_px, camera.height_px, model_, fixed, frame)),
        contrast_(config, light_, model_.contrast_dots, model_.contrast_spread),
        curves_(model_),
        window_px_(static_cast<float>(config.match.census_width_px + config.match.block_px - 1)),
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
    const float turn = 2 * std::numbers::pi_v<float> * (d - std::floor(d));
    const float wave = wave_share(slope, window_px_);
    const float cosine = wave * std::cos(turn);
    const float signal_e = signal_in_reach(light_.signal_e(x, y), light_.rise(x, y),
                                           static_cast<float>(model_.reach_px));
    const Curves::Values at = curves_(contrast_(signal_e, light_.ambient_e(x, y)));
    const float passes =
        at.score + at.score_wave * cosine - static_cast<float>(model_.slope_fill) * slope * slope;
    if (!(light_.signal_e(x, y) > 0) || noise_.hole(x, y) > passes) {
      return (hidden & kHiddenFromProjector) ? InvalidReason::no_projector
                                             : InvalidReason::no_texture;
    }
    const float found = d + error_px(x, y, at, slope, cosine, wave * std::sin(turn));
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

  float error_px(int x, int y, const Curves::Values& at, float slope, float cosine,
                 float sine) const {
    const float tilt = slope * std::sqrt(slope);
    return static_cast<float>(model_.bias_px) + at.ripple * sine +
           std::hypot(at.spatial * (1 + at.spatial_wave * cosine),
                      static_cast<float>(model_.slope_spatial) * tilt) *
               noise_.spatial(x, y) +
           std::hypot(at.temporal * (1 + at.temporal_wave * cosine),
                      static_cast<float>(model_.slope_temporal) * tilt) *
               noise_.temporal(x, y);
  }

  const DepthModelInputs& inputs_;
  const DepthModelConfig& model_;
  const Camera& camera_;
  Image<float> truth_px_, near_px_, rim_px_;
  PatternLight light_;
  NoiseFields noise_;
  MatchContrast contrast_;
  Curves curves_;
  float window_px_, step_, most_, least_;
};

}  // namespace

Fields fields(DepthModelConfig& c) {
  return {
      {"contrast_dots", &c.contrast_dots, "share of the dots' photon noise in the contrast", 0, 9},
      {"contrast_spread", &c.contrast_spread, "area of a dot as windows see it, over its own", 0.1,
       10},
      {"reach_px", &c.reach_px, "from how far brighter places of a surface help", 0, 64},
      {"contrast", &c.contrast, "knots: log2 of the matcher's contrast", 0, 40},
      {"spatial_px", &c.spatial_px, "sigma of the fixed noise at the knots", 0, 100},
      {"spatial_wave", &c.spatial_wave, "its share that goes as cos(2 pi d)", -0.9, 0.9},
      {"temporal_px", &c.temporal_px, "sigma of each image's noise at the knots", 0, 100},
      {"temporal_wave", &c.temporal_wave, "its share that goes as cos(2 pi d)", -0.9, 0.9},
      {"ripple_px", &c.ripple_px, "amplitude of d + A sin(2 pi d) at the knots", -1, 1},
      {"fill_score", &c.fill_score, "normal quantile of the share with a depth", -10, 10},
      {"fill_wave", &c.fill_wave, "amplitude of cos(2 pi d) of the score", -10, 10},
      {"slope_spatial", &c.slope_spatial, "spatial sigma at a disparity slope of 1", 0, 100},
      {"slope_temporal", &c.slope_temporal, "temporal sigma at a disparity slope of 1", 0, 100},
      {"slope_fill", &c.slope_fill, "score lost at a disparity slope of 1", 0, 1e4},
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
  const std::size_t knots = config.contrast.size();
  std::string sizes = std::to_string(knots);
  bool fits = knots >= 2;
  for (const auto* curve :
       {&config.fill_score, &config.fill_wave, &config.spatial_px, &config.spatial_wave,
        &config.temporal_px, &config.temporal_wave, &config.ripple_px}) {
    sizes += ", " + std::to_string(curve->size());
    fits = fits && curve->size() == knots;
  }
  if (!fits) {
    throw std::invalid_argument("depth model: contrast and its curves have " + sizes +
                                " numbers; they must be as many, at least 2");
  }
  for (std::size_t i = 1; i < knots; ++i) {
    if (!(config.contrast[i] > config.contrast[i - 1]))
      throw std::invalid_argument("depth model: contrast must increase");
  }
}

double at_knots(const std::vector<double>& x, const std::vector<double>& y, double at) {
  if (!(at > x.front())) return y.front();
  if (at >= x.back()) return y.back();
  std::size_t i = 1;
  while (x[i] < at) ++i;
  const double t = (at - x[i - 1]) / (x[i] - x[i - 1]);
  return y[i - 1] * (1 - t) + y[i] * t;
}

float wave_share(float slope, float window_px) {
  const float turns = slope * window_px, squared = turns * turns;
  return squared < 1 ? (1 - squared) * (1 - 0.64F * squared) : 0;  // sin(pi t) / (pi t) to 0.02
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
