#include "benchmarks/fit_sensor/model_curves.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include "sim/sensors/fast_normal.h"
#include "sim/sensors/match_contrast.h"

namespace cousin {
namespace {

std::string numbered(const char* format, double a, double b, double c) {
  char out[200];
  std::snprintf(out, sizeof out, format, a, b, c);
  return out;
}

std::string number(double value) {
  char out[40];
  std::snprintf(out, sizeof out, "%.4f", value);
  return out;
}

std::string list(const std::vector<double>& values) {
  std::string out = "[";
  for (const double v : values) out += (out.size() > 1 ? ", " : "") + number(v);
  return out + "]";
}

/// Median in the middle half of an image.
double middle_median(const Image<float>& image) {
  std::vector<float> middle;
  for (int y = image.height() / 4; y < 3 * image.height() / 4; y += 4) {
    for (int x = image.width() / 4; x < 3 * image.width() / 4; x += 4)
      middle.push_back(image(x, y));
  }
  const auto at = middle.begin() + static_cast<std::ptrdiff_t>(middle.size() / 2);
  std::nth_element(middle.begin(), at, middle.end());
  return static_cast<double>(*at);
}

/// What the model's curves run over, at one wall.
struct WallLight {
  double log2_snr, contrast;
};
WallLight wall_light(const WallStatistics& wall, const ActiveStereoConfig& config) {
  const PlaneBefore plane{wall.depth_m, 0, wall.incidence_rad, wall.albedo, wall.light};
  const PatternLight light = pattern_light(plane_inputs(plane, config), config);
  const double log2_snr = middle_median(log2_pattern_snr(light, config.model.noise_from));
  const MatchContrast contrast(config, light, config.model.fill_dots, config.model.fill_spread);
  return {std::max(log2_snr, -20.0),
          static_cast<double>(contrast(static_cast<float>(middle_median(light.signal_e)),
                                       static_cast<float>(middle_median(light.ambient_e))))};
}

/// What a fit says at one place of a curve's axis: a sigma of each noise, or a score.
struct Knot {
  double x;
  std::array<double, 2> value;
};

/// Those nearer than 0.1 to each other as one.
std::vector<Knot> merged(std::vector<Knot> knots) {
  std::sort(knots.begin(), knots.end(), [](const Knot& a, const Knot& b) { return a.x < b.x; });
  std::vector<Knot> result;
  for (const Knot& k : knots) {
    if (result.empty() || k.x - result.back().x > 0.1) {
      result.push_back(k);
      continue;
    }
    for (std::size_t i = 0; i < k.value.size(); ++i)
      result.back().value[i] = 0.5 * (result.back().value[i] + k.value[i]);
  }
  return result;
}

/// The preset's knots below the first and above the last, moved by `move(preset's value at a knot,
/// preset's at the edge, fitted at the edge)`.
template <class Move>
std::vector<Knot> continued(const std::vector<Knot>& inner, const std::vector<double>& x,
                            const std::array<const std::vector<double>*, 2>& curves,
                            const Move& move) {
  std::vector<Knot> result;
  const auto add_beyond = [&](const Knot& edge, bool below) {
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (below ? x[i] > edge.x - 0.1 : x[i] < edge.x + 0.1) continue;
      Knot knot{x[i], {}};
      for (std::size_t k = 0; k < knot.value.size(); ++k)
        knot.value[k] = move((*curves[k])[i], at_knots(x, *curves[k], edge.x), edge.value[k]);
      result.push_back(knot);
    }
  };
  add_beyond(inner.front(), true);
  result.insert(result.end(), inner.begin(), inner.end());
  add_beyond(inner.back(), false);
  if (result.size() == 1) result.push_back({result.front().x + 1, result.front().value});
  return result;
}

/// Sigmas over the pattern's ratio, a knot a wall.
std::vector<Knot> noise_knots(const DepthFit& fit, const ActiveStereoConfig& config) {
  const DepthModelConfig& model = config.model;
  std::vector<Knot> knots;
  for (const WallStatistics& w : fit.walls) {
    if (!w.problem.empty()) continue;
    const bool is_of_law = std::any_of(fit.held_out.begin(), fit.held_out.end(),
                                       [&](const HeldOut& h) { return h.wall == w.name; });
    const double x = wall_light(w, config).log2_snr;
    const double temporal = is_of_law ? value_at(fit.temporal, w.depth_m) : w.temporal_px.value;
    knots.push_back(
        {x,
         {is_of_law ? value_at(fit.spatial, w.depth_m) : w.spatial_px.value,
          fit.temporal_solved ? temporal : at_knots(model.log2_snr, model.temporal_px, x)}});
  }
  return continued(merged(knots), model.log2_snr, {&model.spatial_px, &model.temporal_px},
                   [](double preset, double preset_at_edge, double fitted) {
                     return std::min(100.0, preset * fitted / std::max(preset_at_edge, 1e-3));
                   });
}

/// The fill's score over the matcher's contrast, a knot a wall. A wall without a hole only says
/// that its score is at least that of one hole in some thousand windows.
std::vector<Knot> fill_knots(const DepthFit& fit, const ActiveStereoConfig& config) {
  constexpr double kRarest = 3e-4;
  const DepthModelConfig& model = config.model;
  std::vector<Knot> knots;
  for (const WallStatistics& w : fit.walls) {
    if (!w.problem.empty()) continue;
    const double x = wall_light(w, config).contrast;
    const double slope = config.baseline_m / w.depth_m * std::tan(w.incidence_rad);
    double score = normal_quantile(std::clamp(w.fill.value, kRarest, 1 - kRarest)) +
                   model.slope_fill * slope * slope;
    if (w.fill.value > 1 - kRarest)
      score = std::max(score, at_knots(model.contrast, model.fill_score, x));
    knots.push_back({x, {score, 0}});
  }
  std::vector<Knot> result =
      continued(merged(knots), model.contrast, {&model.fill_score, &model.fill_score},
                [](double preset, double preset_at_edge, double fitted) {
                  return preset + fitted - preset_at_edge;
                });
  for (Knot& k : result) k.value[0] = std::clamp(k.value[0], -10.0, 10.0);
  return result;
}

std::vector<double> places(const std::vector<Knot>& knots) {
  std::vector<double> result;
  for (const Knot& k : knots) result.push_back(k.x);
  return result;
}
std::vector<double> values(const std::vector<Knot>& knots, std::size_t i) {
  std::vector<double> result;
  for (const Knot& k : knots) result.push_back(k.value[i]);
  return result;
}
/// A curve of the preset at other knots.
std::vector<double> moved(const std::vector<double>& x, const std::vector<double>& y,
                          const std::vector<double>& to) {
  std::vector<double> result;
  for (const double at : to) result.push_back(at_knots(x, y, at));
  return result;
}

}  // namespace

DepthModelInputs plane_inputs(const PlaneBefore& plane, const ActiveStereoConfig& config) {
  const Camera camera = depth_camera(config);
  const Eigen::Vector3d normal = Eigen::AngleAxisd(plane.turn_x_rad, Eigen::Vector3d::UnitX()) *
                                 Eigen::AngleAxisd(plane.turn_y_rad, Eigen::Vector3d::UnitY()) *
                                 Eigen::Vector3d(0, 0, -1);
  const int width = camera.width_px, height = camera.height_px;
  const double sky = plane.light * config.infrared.sky_share;
  DepthModelInputs in;
  in.depth_m = Image<float>(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Eigen::Vector3d ray((x - camera.cx_px) / camera.fx_px,
                                (y - camera.cy_px) / camera.fy_px, 1);
      const double along = normal.dot(ray);
      in.depth_m(x, y) = along < 0 ? static_cast<float>(plane.depth_m * normal.z() / along)
                                   : std::numeric_limits<float>::quiet_NaN();
    }
  }
  in.normal = Image<Eigen::Vector3f>(width, height, normal.cast<float>());
  in.albedo = Image<float>(width, height, static_cast<float>(plane.albedo));
  in.ambient =
      Image<float>(width, height, static_cast<float>(plane.albedo * sky * std::numbers::inv_pi));
  in.hidden = Image<std::uint8_t>(width, height, std::uint8_t{0});
  // A passive camera needs a pattern of the wall's own: that of the walls its preset is fitted to.
  in.texture = config.has_projector ? 0 : 0.6 / std::sqrt(12.0);
  return in;
}

void set_even_noise(DepthModelConfig& model, double spatial_px, double temporal_px, double fill,
                    double ripple_px) {
  const double score = normal_quantile(std::clamp(fill, 1e-9, 1 - 1e-9));
  model.log2_snr = {-1, 1};
  model.spatial_px = {spatial_px, spatial_px};
  model.temporal_px = {temporal_px, temporal_px};
  model.ripple_px = {ripple_px, ripple_px};
  model.contrast = {0, 1};
  model.fill_score = {score, score};
  model.spatial_wave = model.temporal_wave = model.fill_wave = {0, 0};
}

ModelCurves model_curves(const DepthFit& fit, const ActiveStereoConfig& config,
                         const std::string& data) {
  const DepthModelConfig& model = config.model;
  const std::vector<Knot> noise = noise_knots(fit, config), fill = fill_knots(fit, config);
  const std::vector<double> x = places(noise), contrast = places(fill);
  const std::string words = data + "; beyond its walls the preset's, scaled";
  const std::string shape = "the preset's at these knots";
  ModelCurves out;
  const auto add = [&](const char* key, const std::vector<double>& curve, const std::string& why) {
    out.entries.push_back({key, list(curve), why});
  };
  add("model.log2_snr", x, words);
  add("model.spatial_px", values(noise, 0), words);
  add("model.temporal_px", values(noise, 1),
      fit.temporal_solved ? words : shape + ": rounding hides the temporal noise");
  add("model.spatial_wave", moved(model.log2_snr, model.spatial_wave, x), shape);
  add("model.temporal_wave", moved(model.log2_snr, model.temporal_wave, x), shape);
  add("model.contrast", contrast, words);
  add("model.fill_score", values(fill, 0), words);
  add("model.fill_wave", moved(model.contrast, model.fill_wave, contrast), shape);
  const auto interval = [&](const WithInterval& v) {
    return data + numbered(", 95 %% [%.4f, %.4f] px%.0s", v.low, v.high, 0);
  };
  if (fit.ripple_solved) {
    add("model.ripple_px", std::vector<double>(x.size(), fit.ripple_px.value),
        interval(fit.ripple_px));
  } else {
    add("model.ripple_px", moved(model.log2_snr, model.ripple_px, x), shape);
  }
  if (fit.bias_solved)
    out.entries.push_back({"model.bias_px", number(fit.bias_px.value), interval(fit.bias_px)});
  return out;
}

}  // namespace cousin
