#include "benchmarks/suites/sensors/colour_rows.h"

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>

#include "benchmarks/suites/sensors/flat_fields.h"
#include "benchmarks/suites/sensors/moving_edge.h"
#include "benchmarks/suites/sensors/sensor_row.h"
#include "sim/sensors/rig.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

using Rows = std::vector<ScoreRow>;

/// A quick run measures the same with fewer frames; what is random then has wider limits, five
/// standard errors of the estimate at these numbers.
struct Effort {
  int exposures, frames;
  double slope_limit, intercept_limit, ring_limit;
};
constexpr Effort kFull{50, 16, 0.005, 0.02, 0.001};
constexpr Effort kQuick{12, 6, 0.005, 0.04, 0.001};

void photon_transfer_rows(const SensorRows& of, std::uint64_t stream,
                          const CameraSensorConfig& flat, const Effort& effort, Rows& rows) {
  const CameraUnit unit = make_camera_unit(flat, Rng(stream).fork("photon_transfer"));
  const PhotonTransfer t = photon_transfer(flat, unit, effort.exposures, stream + 100);
  const double k = codes_per_electron(flat.photosites);
  const double expected = expected_intercept(flat.photosites);
  const auto row = [&](const char* metric, double value, const char* unit_text) {
    return sensor_row(of, "photon transfer", metric, value, unit_text, t.photosites);
  };
  // Every fourth, for the plot.
  for (std::size_t i = 0; i < t.points.size(); i += 4) {
    char name[64];
    std::snprintf(name, sizeof name, "photon transfer at %.4g DN", t.points[i].mean);
    rows.push_back(sensor_row(of, name, "variance", t.points[i].variance, "DN2", t.photosites));
  }
  const double slope_error = t.slope / k - 1, intercept_error = t.intercept / expected - 1;
  rows.push_back(row("slope", t.slope, "DN/e"));
  rows.push_back(
      limited(row("slope.relative_error", slope_error, "1"), about(0, effort.slope_limit)));
  rows.push_back(row("intercept", t.intercept, "DN2"));
  rows.push_back(limited(row("intercept.relative_error", intercept_error, "1"),
                         about(0, effort.intercept_limit)));
}

void fixed_pattern_rows(const SensorRows& of, std::uint64_t stream, const CameraSensorConfig& flat,
                        const Effort& effort, Rows& rows) {
  const CameraUnit unit = make_camera_unit(flat, Rng(stream).fork("fixed_pattern"));
  const FixedPattern p = fixed_pattern(flat, unit, effort.frames, stream + 300);
  const auto row = [&](const char* metric, double value, const char* unit_text) {
    return sensor_row(of, "fixed pattern", metric, value, unit_text, p.photosites);
  };
  // Five standard errors, and what the two maps correlate by chance: 0.15 % of the offsets at most.
  const auto pair = [&](const std::string& name, double value, double sigma, double truth,
                        const char* unit_text) {
    ScoreRow measured = row(name.c_str(), value, unit_text);
    measured.ci_low = value - 1.96 * sigma;
    measured.ci_high = value + 1.96 * sigma;
    rows.push_back(measured);
    rows.push_back(limited(row((name + ".relative_error").c_str(), value / truth - 1, "1"),
                           about(0, 5 * sigma / truth + 0.0015)));
  };
  pair("prnu", p.prnu, p.prnu_sigma, p.true_prnu, "1");
  pair("dsnu", p.dsnu_e, p.dsnu_sigma_e, p.true_dsnu_e, "e");
}

void optics_rows(const SensorRows& of, std::uint64_t stream, const CameraSensorConfig& config,
                 const Effort& effort, Rows& rows) {
  const double deviation = vignetting_deviation(config, effort.frames, stream + 2000);
  rows.push_back(limited(sensor_row(of, "vignetting", "largest_ring_deviation", deviation, "1", 16),
                         at_most(effort.ring_limit)));
  const LateralColour colour = measure_lateral_colour(config);
  rows.push_back(
      sensor_row(of, "lateral colour", "largest_displacement", colour.displacement_px, "px", 1));
  rows.push_back(
      limited(sensor_row(of, "lateral colour", "error", colour.error_px, "px", 1), at_most(0.005)));
}

/// Exact geometry: what is left is the float positions of the truth pass.
void motion_rows(const SensorRows& of, const RigConfig& rig, Rows& rows) {
  const MovingEdge edge = measure_moving_edge(rig, 0);
  const auto pair = [&](const char* name, double value, double expected) {
    rows.push_back(sensor_row(of, name, "length", value, "px", 1));
    rows.push_back(
        limited(sensor_row(of, name, "error", value - expected, "px", 1), about(0, 0.01)));
  };
  pair("rolling-shutter skew", edge.skew_px, edge.expected_skew_px);
  pair("motion blur", edge.blur_px, edge.expected_blur_px);
}

void speed_row(const SensorRows& of, const RigConfig& rig, Rows& rows) {
  const CameraSensorConfig& config = rig.sensors.front().camera;
  const CameraUnit unit = make_camera_unit(config, Rng(of.seed).fork("speed"));
  TrueView view;
  view.camera = unit.lens.at_infinity;
  const Image<Rgbf> radiance(config.width_px, config.height_px, {0.3F, 0.4F, 0.2F});
  const StageClock clock("sense");
  const SensorFrame frame = sense(radiance, config, unit, view, Rng(of.seed));
  const double wall_s = clock.finish().wall_s;
  ScoreRow row = sensor_row(of, "whole frame", "seconds.sense", wall_s, "s",
                            static_cast<std::int64_t>(frame.color.size()));
  row.wall_s = wall_s;
  row.peak_rss_mb = peak_rss_mb();
  row.peak_above_start_mb = row.peak_rss_mb - start_rss_mb();
  rows.push_back(row);
}

}  // namespace

std::vector<ScoreRow> colour_rows(std::uint64_t seed, bool quick) {
  const Effort& effort = quick ? kQuick : kFull;
  Rows rows;
  for (const std::string& name : rig_preset_names()) {
    const RigConfig rig = rig_preset(name);
    const SensorRows of{name, seed};
    const CameraSensorConfig& config = rig.sensors.front().camera;
    const CameraSensorConfig flat = flat_camera(config);
    const std::uint64_t stream = Rng(seed).fork(name)();  // presets do not share their noise
    photon_transfer_rows(of, stream, flat, effort, rows);
    fixed_pattern_rows(of, stream, flat, effort, rows);
    optics_rows(of, stream, config, effort, rows);
    motion_rows(of, rig, rows);
    speed_row(of, rig, rows);
  }
  return rows;
}

}  // namespace cousin
