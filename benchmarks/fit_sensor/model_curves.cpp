#include "benchmarks/fit_sensor/model_curves.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

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

/// Noise and fill at one signal-to-noise ratio.
struct Knot {
  double log2_snr, spatial_px, temporal_px, fill;
};

/// Median ratio in the middle half of a wall's image.
double wall_log2_snr(const WallStatistics& wall, const ActiveStereoConfig& config) {
  const PlaneBefore plane{wall.depth_m, 0, wall.incidence_rad, wall.albedo, wall.light};
  const Image<float> snr =
      pattern_snr(pattern_light(plane_inputs(plane, config), config), config.model.margin_weight);
  std::vector<float> middle;
  for (int y = snr.height() / 4; y < 3 * snr.height() / 4; y += 4) {
    for (int x = snr.width() / 4; x < 3 * snr.width() / 4; x += 4) middle.push_back(snr(x, y));
  }
  const auto at = middle.begin() + static_cast<std::ptrdiff_t>(middle.size() / 2);
  std::nth_element(middle.begin(), at, middle.end());
  return std::log2(std::max(static_cast<double>(*at), 1e-6));
}

/// The preset's curve, linear between its knots.
double at_knots(const std::vector<double>& x, const std::vector<double>& y, double at) {
  if (at <= x.front()) return y.front();
  if (at >= x.back()) return y.back();
  std::size_t i = 1;
  while (x[i] < at) ++i;
  const double t = (at - x[i - 1]) / (x[i] - x[i - 1]);
  return y[i - 1] * (1 - t) + y[i] * t;
}

/// One knot a wall, those nearer than 0.1 to each other merged.
std::vector<Knot> knots_of(const DepthFit& fit, const ActiveStereoConfig& config) {
  std::vector<Knot> knots;
  for (const WallStatistics& w : fit.walls) {
    if (!w.problem.empty()) continue;
    const bool is_of_law = std::any_of(fit.held_out.begin(), fit.held_out.end(),
                                       [&](const HeldOut& h) { return h.wall == w.name; });
    const double x = wall_log2_snr(w, config);
    const double preset = at_knots(config.model.log2_snr, config.model.temporal_px, x);
    const double temporal = is_of_law ? value_at(fit.temporal, w.depth_m) : w.temporal_px.value;
    knots.push_back({x, is_of_law ? value_at(fit.spatial, w.depth_m) : w.spatial_px.value,
                     fit.temporal_solved ? temporal : preset, w.fill.value});
  }
  std::sort(knots.begin(), knots.end(),
            [](const Knot& a, const Knot& b) { return a.log2_snr < b.log2_snr; });
  std::vector<Knot> merged;
  for (const Knot& k : knots) {
    if (merged.empty() || k.log2_snr - merged.back().log2_snr > 0.1) {
      merged.push_back(k);
      continue;
    }
    Knot& last = merged.back();
    last.spatial_px = 0.5 * (last.spatial_px + k.spatial_px);
    last.temporal_px = 0.5 * (last.temporal_px + k.temporal_px);
    last.fill = 0.5 * (last.fill + k.fill);
  }
  return merged;
}

/// The preset's knots beyond `edge`, scaled by what the fit is of the preset there.
std::vector<Knot> beyond(const Knot& edge, bool below, const DepthModelConfig& model) {
  const auto ratio = [&](const std::vector<double>& curve, double fitted) {
    return fitted / std::max(at_knots(model.log2_snr, curve, edge.log2_snr), 1e-3);
  };
  std::vector<Knot> knots;
  for (std::size_t i = 0; i < model.log2_snr.size(); ++i) {
    const double x = model.log2_snr[i];
    if (below ? x > edge.log2_snr - 0.1 : x < edge.log2_snr + 0.1) continue;
    const double fill = model.fill[i] * ratio(model.fill, edge.fill);
    knots.push_back(
        {x, model.spatial_px[i] * ratio(model.spatial_px, edge.spatial_px),
         model.temporal_px[i] * ratio(model.temporal_px, edge.temporal_px),
         std::clamp(below ? std::min(fill, edge.fill) : std::max(fill, edge.fill), 0.0, 1.0)});
  }
  return knots;
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
  model.log2_snr = {-1, 1};
  model.spatial_px = {spatial_px, spatial_px};
  model.temporal_px = {temporal_px, temporal_px};
  model.fill = {fill, fill};
  model.ripple_px = ripple_px;
}

ModelCurves model_curves(const DepthFit& fit, const ActiveStereoConfig& config,
                         const std::string& data) {
  const std::vector<Knot> inner = knots_of(fit, config);
  std::vector<Knot> knots = beyond(inner.front(), true, config.model);
  knots.insert(knots.end(), inner.begin(), inner.end());
  const std::vector<Knot> above = beyond(inner.back(), false, config.model);
  knots.insert(knots.end(), above.begin(), above.end());
  std::vector<double> x, spatial, temporal, fill;
  for (const Knot& k : knots) {
    x.push_back(k.log2_snr);
    spatial.push_back(std::min(k.spatial_px, 100.0));
    temporal.push_back(std::min(k.temporal_px, 100.0));
    fill.push_back(k.fill);
  }
  const std::string range = numbered("; below %.2f and above %.2f the preset's, scaled%.0s",
                                     inner.front().log2_snr, inner.back().log2_snr, 0);
  ModelCurves out;
  out.entries.push_back({"model.log2_snr", list(x), data + range});
  out.entries.push_back({"model.spatial_px", list(spatial), data + range});
  if (fit.temporal_solved)
    out.entries.push_back({"model.temporal_px", list(temporal), data + range});
  else
    out.entries.push_back({"model.temporal_px", list(temporal),
                           "the preset's at these knots: rounding hides the temporal noise"});
  out.entries.push_back({"model.fill", list(fill), data + range});
  const auto add = [&](const char* key, const WithInterval& v) {
    out.entries.push_back(
        {key, number(v.value), data + numbered(", 95 %% [%.4f, %.4f] px%.0s", v.low, v.high, 0)});
  };
  if (fit.ripple_solved) add("model.ripple_px", fit.ripple_px);
  if (fit.bias_solved) add("model.bias_px", fit.bias_px);
  return out;
}

}  // namespace cousin
