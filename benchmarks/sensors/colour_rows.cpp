#include "benchmarks/sensors/colour_rows.h"

#include <cmath>
#include <cstdint>
#include <string>

#include "benchmarks/sensors/flat_fields.h"
#include "benchmarks/sensors/moving_edge.h"
#include "benchmarks/sensors/sensor_row.h"
#include "sim/sensors/rig.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

using Rows = std::vector<ScoreRow>;

/// A quick run measures the same with fewer frames; what is random then has wider limits, five
/// standard errors of the estimate at these numbers.
struct Effort {
  int exposures, frames;
  double slope_limit, intercept_limit, pattern_limit, ring_limit;
};
constexpr Effort kFull{50, 16, 0.005, 0.02, 0.01, 0.001};
constexpr Effort kQuick{12, 6, 0.005, 0.04, 0.02, 0.001};

void photon_transfer_rows(const SensorRows& of, const CameraSensorConfig& flat,
                          const Effort& effort, Rows& rows) {
  const CameraUnit unit = make_camera_unit(flat, Rng(of.seed).fork("photon_transfer"));
  const PhotonTransfer t = photon_transfer(flat, unit, effort.exposures, of.seed + 100);
  const double k = codes_per_electron(flat.photosites);
  const double expected = expected_intercept(flat.photosites);
  const auto row = [&](const char* metric, double value, const char* unit_text) {
    return sensor_row(of, "photon transfer", metric, value, unit_text, t.photosites);
  };
  const double slope_error = t.slope / k - 1, intercept_error = t.intercept / expected - 1;
  rows.push_back(row("slope", t.slope, "DN/e"));
  rows.push_back(limited(row("slope.relative_error", slope_error, "1"),
                         std::abs(slope_error) <= effort.slope_limit));
  rows.push_back(row("intercept", t.intercept, "DN2"));
  rows.push_back(limited(row("intercept.relative_error", intercept_error, "1"),
                         std::abs(intercept_error) <= effort.intercept_limit));
}

void fixed_pattern_rows(const SensorRows& of, const CameraSensorConfig& flat, const Effort& effort,
                        Rows& rows) {
  const CameraUnit unit = make_camera_unit(flat, Rng(of.seed).fork("fixed_pattern"));
  const FixedPattern p = fixed_pattern(flat, unit, effort.frames, of.seed + 300);
  const auto row = [&](const char* metric, double value, const char* unit_text) {
    return sensor_row(of, "fixed pattern", metric, value, unit_text, p.photosites);
  };
  const double prnu_error = p.prnu / p.true_prnu - 1, dsnu_error = p.dsnu_e / p.true_dsnu_e - 1;
  rows.push_back(row("prnu", p.prnu, "1"));
  rows.push_back(limited(row("prnu.relative_error", prnu_error, "1"),
                         std::abs(prnu_error) <= effort.pattern_limit));
  rows.push_back(row("dsnu", p.dsnu_e, "e"));
  // The dark pattern stands against the read noise, many times larger: twice the limit.
  rows.push_back(limited(row("dsnu.relative_error", dsnu_error, "1"),
                         std::abs(dsnu_error) <= 2 * effort.pattern_limit));
}

void optics_rows(const SensorRows& of, const CameraSensorConfig& config, const Effort& effort,
                 Rows& rows) {
  const double deviation = vignetting_deviation(config, effort.frames, of.seed + 2000);
  rows.push_back(limited(sensor_row(of, "vignetting", "largest_ring_deviation", deviation, "1", 16),
                         deviation <= effort.ring_limit));
  const LateralColour colour = measure_lateral_colour(config);
  rows.push_back(
      sensor_row(of, "lateral colour", "largest_displacement", colour.displacement_px, "px", 1));
  rows.push_back(limited(sensor_row(of, "lateral colour", "error", colour.error_px, "px", 1),
                         colour.error_px <= 0.005));
}

/// Exact geometry: what is left is the float positions of the truth pass.
void motion_rows(const SensorRows& of, const RigConfig& rig, Rows& rows) {
  const MovingEdge edge = measure_moving_edge(rig, 0);
  const auto pair = [&](const char* name, double value, double expected) {
    rows.push_back(sensor_row(of, name, "length", value, "px", 1));
    rows.push_back(limited(sensor_row(of, name, "error", value - expected, "px", 1),
                           std::abs(value - expected) <= 0.01));
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
    photon_transfer_rows(of, flat, effort, rows);
    fixed_pattern_rows(of, flat, effort, rows);
    optics_rows(of, config, effort, rows);
    motion_rows(of, rig, rows);
    speed_row(of, rig, rows);
  }
  return rows;
}

}  // namespace cousin
