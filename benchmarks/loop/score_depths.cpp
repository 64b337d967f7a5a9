#include "benchmarks/loop/score_depths.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>

#include "benchmarks/loop/score_geometry.h"
#include "benchmarks/score/order_statistics.h"

namespace cousin {
namespace {

/// Errors of the measured pixels of one case.
struct DepthErrors {
  std::int64_t there = 0;  ///< pixels that show a surface
  std::vector<double> error_m, relative, normalised;
  std::vector<double> off_px;
};

/// Depth times disparity of the first camera and the rig's next; 0 without one.
double focal_baseline(const SceneTruth& truth, std::size_t view) {
  const auto other =
      std::find_if(truth.other_sensors.begin(), truth.other_sensors.end(),
                   [](const SensorViews& sensor) { return sensor.sensor != kDepthSensor; });
  if (other == truth.other_sensors.end() || view >= other->views.size()) return 0;
  const TrueView& left = truth.views[view];
  const TrueView& right = other->views[view];
  const Eigen::Vector3d apart_m =
      (right.camera_from_world * inverse(left.camera_from_world)).translation_m;
  return left.camera.fx_px * apart_m.norm();
}

/// @throws std::invalid_argument for a depth that is none and not NaN
void check_depths(const FrameDepth& depth) {
  for (const float z_m : depth.depth_m) {
    if (std::isnan(z_m) || (z_m > 0 && std::isfinite(z_m))) continue;
    throw std::invalid_argument("the depth of frame " + std::to_string(depth.frame) +
                                " has a pixel of " + std::to_string(z_m) +
                                " m; what is not known is NaN");
  }
}

std::string octave_name(int power) {
  char text[48];
  std::snprintf(text, sizeof text, "%g to %g m", std::exp2(power), std::exp2(power + 1));
  return text;
}

void add_pixel(double true_m, double measured_m, double sigma_m, double fb, DepthErrors& errors) {
  ++errors.there;
  if (std::isnan(measured_m)) return;
  const double off_m = measured_m - true_m;
  errors.error_m.push_back(off_m);
  errors.relative.push_back(std::abs(off_m) / true_m);
  if (sigma_m > 0) errors.normalised.push_back(std::abs(off_m) / sigma_m);
  if (!(fb > 0)) return;
  errors.off_px.push_back(fb / measured_m - fb / true_m);
}

std::vector<double> sizes_of(const std::vector<double>& values) {
  std::vector<double> sizes;
  sizes.reserve(values.size());
  for (const double v : values) sizes.push_back(std::abs(v));
  return sizes;
}

void add_disparity_rows(const std::vector<double>& off_px, const ScoreRow& base,
                        std::vector<ScoreRow>& rows) {
  if (off_px.empty()) return;
  const auto n = static_cast<std::int64_t>(off_px.size());
  const auto add = [&](const char* metric, double value, const char* unit) {
    rows.push_back(measured_row(base, metric, value, unit, n));
  };
  const auto bad = [&](double limit_px) {
    const auto count = std::count_if(off_px.begin(), off_px.end(),
                                     [&](double off) { return std::abs(off) > limit_px; });
    return static_cast<double>(count) / static_cast<double>(n);
  };
  add("depth.bad_05_px", bad(0.5), "1");
  add("depth.bad_1_px", bad(1), "1");
  add("depth.bad_2_px", bad(2), "1");
  const double offset_px = quantile(off_px, 0.5);
  std::vector<double> about_px;
  for (const double off : off_px) about_px.push_back(std::abs(off - offset_px));
  add("depth.offset_px", offset_px, "px");
  add("depth.spread_px", 1.4826 * quantile(about_px, 0.5), "px");
}

void add_rows(const DepthErrors& errors, const ScoreRow& base, std::vector<ScoreRow>& rows) {
  const auto add = [&](const char* metric, double value, const char* unit, std::int64_t n) {
    rows.push_back(measured_row(base, metric, value, unit, n));
  };
  if (errors.there == 0) return;
  const auto n = static_cast<std::int64_t>(errors.error_m.size());
  add("depth.measured", static_cast<double>(n) / static_cast<double>(errors.there), "1",
      errors.there);
  if (n == 0) return;
  add("depth.error", quantile(sizes_of(errors.error_m), 0.5), "m", n);
  add("depth.error_relative", quantile(errors.relative, 0.5), "1", n);
  add("depth.bias", quantile(errors.error_m, 0.5), "m", n);
  add_disparity_rows(errors.off_px, base, rows);
  if (errors.normalised.empty()) return;
  const auto known = static_cast<std::int64_t>(errors.normalised.size());
  const auto within = std::count_if(errors.normalised.begin(), errors.normalised.end(),
                                    [](double v) { return v <= 1.96; });
  add("depth.coverage_95", static_cast<double>(within) / static_cast<double>(known), "1", known);
  add("depth.normalised", quantile(errors.normalised, 0.5), "1", known);
}

}  // namespace

std::vector<ScoreRow> score_depths(const SceneTruth& truth, const Estimate& estimate,
                                   const SeedsScoreLabels& labels) {
  std::map<int, const FrameDepth*> depth_of;
  for (const FrameDepth& depth : estimate.depths) depth_of[depth.frame] = &depth;
  std::map<int, DepthErrors> octaves;  ///< by the power of two of their nearest
  DepthErrors whole;
  std::int64_t frames = 0;
  for (std::size_t i = 0; i < truth.views.size(); ++i) {
    const TrueView& view = truth.views[i];
    const auto found = depth_of.find(view.frame);
    const FrameDepth* depth = found == depth_of.end() ? nullptr : found->second;
    if (found != depth_of.end()) depth_of.erase(found);
    if (i >= truth.images.size() || truth.images[i].depth_m.empty())
      throw std::invalid_argument("depth cannot be scored: frame " + std::to_string(view.frame) +
                                  " has no true depth (render with --truth depth)");
    const Image<float>& true_m = truth.images[i].depth_m;
    const bool is_there = depth && !depth->depth_m.empty();
    frames += is_there;
    if (is_there &&
        (depth->depth_m.width() != true_m.width() || depth->depth_m.height() != true_m.height()))
      throw std::invalid_argument("the depth of frame " + std::to_string(view.frame) + " has " +
                                  std::to_string(depth->depth_m.width()) + " x " +
                                  std::to_string(depth->depth_m.height()) +
                                  " pixels; its view has " + std::to_string(true_m.width()) +
                                  " x " + std::to_string(true_m.height()));
    if (is_there) check_depths(*depth);
    const double fb = focal_baseline(truth, i);
    for (std::size_t k = 0; k < true_m.size(); ++k) {
      const auto z_m = static_cast<double>(true_m.data()[k]);
      if (!(z_m > 0) || !std::isfinite(z_m)) continue;
      const double measured_m =
          is_there ? static_cast<double>(depth->depth_m.data()[k]) : ScoreRow::kNone;
      const double sigma_m = is_there && !depth->sigma_m.empty()
                                 ? static_cast<double>(depth->sigma_m.data()[k])
                                 : ScoreRow::kNone;
      add_pixel(z_m, measured_m, sigma_m, fb, whole);
      add_pixel(z_m, measured_m, sigma_m, fb,
                octaves[static_cast<int>(std::floor(std::log2(z_m)))]);
    }
  }
  if (!depth_of.empty())
    throw std::invalid_argument("frame " + std::to_string(depth_of.begin()->first) +
                                " of the depths is none of the truth's");
  ScoreRow base = labelled_row(labels);
  base.case_name = "all";
  std::vector<ScoreRow> rows;
  const auto n = static_cast<std::int64_t>(truth.views.size());
  rows.push_back(measured_row(base, "depth.frames",
                              static_cast<double>(frames) / static_cast<double>(n), "1", n));
  add_rows(whole, base, rows);
  for (const auto& [power, errors] : octaves) {
    base.case_name = octave_name(power);
    add_rows(errors, base, rows);
  }
  score_timings(estimate, labelled_row(labels), rows);
  return rows;
}

}  // namespace cousin
