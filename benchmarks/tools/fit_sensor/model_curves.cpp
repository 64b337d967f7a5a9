#include "benchmarks/tools/fit_sensor/model_curves.h"

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
double wall_contrast(const WallStatistics& wall, const ActiveStereoConfig& config) {
  const PlaneBefore plane{wall.depth_m, 0, wall.incidence_rad, wall.albedo, wall.light};
  const PatternLight light = pattern_light(plane_inputs(plane, config), config);
  const MatchContrast contrast(config, light, config.model.contrast_dots,
                               config.model.contrast_spread);
  return static_cast<double>(contrast(static_cast<float>(middle_median(light.signal_e)),
                                      static_cast<float>(middle_median(light.ambient_e))));
}

/// What a fit says at one place of the curves' axis.
struct Knot {
  double x = 0, spatial_px = 0, temporal_px = 0, score = 0;
};

/// Those nearer than 0.05 to each other as one.
std::vector<Knot> merged(std::vector<Knot> knots) {
  std::sort(knots.begin(), knots.end(), [](const Knot& a, const Knot& b) { return a.x < b.x; });
  std::vector<Knot> result;
  for (const Knot& k : knots) {
    if (result.empty() || k.x - result.back().x > 0.05) {
      result.push_back(k);
      continue;
    }
    Knot& last = result.back();
    last.spatial_px = 0.5 * (last.spatial_px + k.spatial_px);
    last.temporal_px = 0.5 * (last.temporal_px + k.temporal_px);
    last.score = 0.5 * (last.score + k.score);
  }
  return result;
}

Knot preset_at(const DepthModelConfig& model, double x) {
  return {x, at_knots(model.contrast, model.spatial_px, x),
          at_knots(model.contrast, model.temporal_px, x),
          at_knots(model.contrast, model.fill_score, x)};
}

/// The preset's knots below the first and above the last; sigmas scaled and scores moved as much as
/// the fit's at that edge.
std::vector<Knot> continued(const std::vector<Knot>& inner, const DepthModelConfig& model) {
  std::vector<Knot> result;
  const auto scaled = [](double preset, double at_edge, double fitted) {
    return std::min(100.0, preset * fitted / std::max(at_edge, 1e-3));
  };
  const auto add_beyond = [&](const Knot& edge, bool below) {
    const Knot own = preset_at(model, edge.x);
    for (const double x : model.contrast) {
      if (below ? x > edge.x - 0.1 : x < edge.x + 0.1) continue;
      const Knot preset = preset_at(model, x);
      result.push_back({x, scaled(preset.spatial_px, own.spatial_px, edge.spatial_px),
                        scaled(preset.temporal_px, own.temporal_px, edge.temporal_px),
                        preset.score + edge.score - own.score});
    }
  };
  add_beyond(inner.front(), true);
  result.insert(result.end(), inner.begin(), inner.end());
  add_beyond(inner.back(), false);
  for (Knot& k : result) k.score = std::clamp(k.score, -10.0, 10.0);
  if (result.size() == 1) {
    result.push_back(result.front());
    result.back().x += 1;
  }
  return result;
}

/// Sigmas and the fill's score, a knot a wall. A wall without a hole only says that its score is at
/// least that of one hole in some thousand windows.
std::vector<Knot> wall_knots(const DepthFit& fit, const ActiveStereoConfig& config) {
  constexpr double kRarest = 3e-4;
  const DepthModelConfig& model = config.model;
  std::vector<Knot> knots;
  for (const WallStatistics& w : fit.walls) {
    if (!w.problem.empty()) continue;
    const bool is_of_law = std::any_of(fit.held_out.begin(), fit.held_out.end(),
                                       [&](const HeldOut& h) { return h.wall == w.name; });
    Knot knot = preset_at(model, wall_contrast(w, config));
    knot.spatial_px = is_of_law ? value_at(fit.spatial, w.depth_m) : w.spatial_px.value;
    if (fit.temporal_solved)
      knot.temporal_px = is_of_law ? value_at(fit.temporal, w.depth_m) : w.temporal_px.value;
    const double slope = config.baseline_m / w.depth_m * std::tan(w.incidence_rad);
    const double score = normal_quantile(std::clamp(w.fill.value, kRarest, 1 - kRarest)) +
                         model.slope_fill * slope * slope;
    knot.score = w.fill.value > 1 - kRarest ? std::max(score, knot.score) : score;
    knots.push_back(knot);
  }
  return continued(merged(knots), model);
}

std::vector<double> values(const std::vector<Knot>& knots, double Knot::*part) {
  std::vector<double> result;
  for (const Knot& k : knots) result.push_back(k.*part);
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
  const std::vector<Knot> knots = wall_knots(fit, config);
  const std::vector<double> x = values(knots, &Knot::x);
  const std::string words = data + "; beyond its walls the preset's, scaled";
  const std::string shape = "the preset's at these knots";
  ModelCurves out;
  const auto add = [&](const char* key, const std::vector<double>& curve, const std::string& why) {
    out.entries.push_back({key, list(curve), why});
  };
  const auto add_preset = [&](const char* key, const std::vector<double>& curve) {
    add(key, moved(model.contrast, curve, x), shape);
  };
  add("model.contrast", x, words);
  add("model.spatial_px", values(knots, &Knot::spatial_px), words);
  add("model.temporal_px", values(knots, &Knot::temporal_px),
      fit.temporal_solved ? words : shape + ": rounding hides the temporal noise");
  add_preset("model.spatial_wave", model.spatial_wave);
  add_preset("model.temporal_wave", model.temporal_wave);
  add("model.fill_score", values(knots, &Knot::score), words);
  add_preset("model.fill_wave", model.fill_wave);
  const auto interval = [&](const WithInterval& v) {
    return data + numbered(", 95 %% [%.4f, %.4f] px%.0s", v.low, v.high, 0);
  };
  if (fit.ripple_solved) {
    add("model.ripple_px", std::vector<double>(x.size(), fit.ripple_px.value),
        interval(fit.ripple_px));
  } else {
    add_preset("model.ripple_px", model.ripple_px);
  }
  if (fit.bias_solved)
    out.entries.push_back({"model.bias_px", number(fit.bias_px.value), interval(fit.bias_px)});
  return out;
}

}  // namespace cousin
