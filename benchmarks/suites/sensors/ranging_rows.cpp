#include "benchmarks/suites/sensors/ranging_rows.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "benchmarks/suites/sensors/depth_wall.h"
#include "benchmarks/suites/sensors/sensor_row.h"
#include "sim/render/ray_scene.h"
#include "sim/sensors/range_rig.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

std::string wall_name(const WallCase& wall) {
  char text[80];
  std::snprintf(text, sizeof text, "wall at %.2f m, %.0f deg, light %.2g of sunlight",
                wall.distance_m, wall.incidence_rad * 180 / M_PI, wall.light / 3);
  return text;
}

/// Errors over the middle half of an image and what they should spread by.
struct Spread {
  double n = 0, sum = 0, squares = 0, expected = 0, asked = 0;
  void add(double error_m, double sigma_m) {
    n += 1;
    sum += error_m;
    squares += error_m * error_m;
    expected += sigma_m * sigma_m;
  }
  double bias_m() const { return sum / n; }
  double sigma_m() const { return std::sqrt(std::max(0.0, squares / n - bias_m() * bias_m())); }
  double expected_m() const { return std::sqrt(expected / n); }
};

/// Of range, by the difference of two exposures: what stays the same is bias, not noise.
Spread time_of_flight_spread(const TimeOfFlightInputs& inputs, const TimeOfFlightConfig& config,
                             const Rng& rng) {
  const TimeOfFlightLight light = time_of_flight_light(inputs, config);
  const TimeOfFlightDepth a = sense_time_of_flight(inputs, light, config, rng.fork("a"));
  const TimeOfFlightDepth b = sense_time_of_flight(inputs, light, config, rng.fork("b"));
  Spread spread;
  for (int y = config.rows / 4; y < 3 * config.rows / 4; ++y) {
    for (int x = config.columns / 4; x < 3 * config.columns / 4; ++x) {
      spread.asked += 1;
      if (a.depth(x, y) == 0 || b.depth(x, y) == 0) continue;
      const double amplitude_e = static_cast<double>(light.modulation.back()(x, y).norm());
      spread.add(
          static_cast<double>(a.range_m(x, y) - b.range_m(x, y)) / std::sqrt(2.0),
          time_of_flight_sigma_m(config, static_cast<double>(light.mean_e(x, y)), amplitude_e));
    }
  }
  return spread;
}

TimeOfFlightInputs inputs_of(const WallCase& wall, const TimeOfFlightConfig& config,
                             const Rng& rng) {
  const WallScene scene = make_wall(wall);
  const RayScene rays(scene.scene);
  return time_of_flight_inputs(rays, scene.scene, scene.rig_from_world, config, rng);
}

/// Mean error of depth about the axis.
double axis_bias_m(const TimeOfFlightInputs& inputs, const TimeOfFlightConfig& config,
                   const Rng& rng) {
  const TimeOfFlightDepth depth =
      sense_time_of_flight(inputs, time_of_flight_light(inputs, config), config, rng);
  double sum = 0, n = 0;
  for (int y = config.rows / 2 - 20; y < config.rows / 2 + 20; ++y) {
    for (int x = config.columns / 2 - 20; x < config.columns / 2 + 20; ++x) {
      if (depth.depth(x, y) == 0) continue;
      sum += depth.depth(x, y) * config.depth_unit_m - double(depth.noise_free_depth_m(x, y));
      n += 1;
    }
  }
  return n > 0 ? sum / n : ScoreRow::kNone;
}

void add_time_of_flight(const std::string& name, std::uint64_t seed, bool quick,
                        std::vector<ScoreRow>& rows) {
  const SensorRows of{name, seed};
  const TimeOfFlightConfig config = time_of_flight_preset(name);
  const Rng rng = Rng(seed).fork("ranging").fork(name);
  std::vector<WallCase> walls = {{0.8, 0, 0.5, 0, 0},
                                 {1.5, 0, 0.5, 0, 0},
                                 {3, 0, 0.5, 0, 0},
                                 {1.5, 0, 0.5, 1, 0},
                                 {1.5, 0.9, 0.5, 0, 0}};
  if (quick) walls.resize(2);
  for (const WallCase& wall : walls) {
    const Spread s =
        time_of_flight_spread(inputs_of(wall, config, rng.fork("light")), config, rng.fork("a"));
    const auto n = static_cast<std::int64_t>(s.n);
    rows.push_back(sensor_row(of, wall_name(wall), "fill", s.n / s.asked, "1",
                              static_cast<std::int64_t>(s.asked)));
    if (s.n < 1000) continue;
    rows.push_back(sensor_row(of, wall_name(wall), "sigma_range", s.sigma_m(), "m", n));
    // First-order propagation; above a thousand pixels chance leaves 2 %.
    const double ratio = s.sigma_m() / s.expected_m();
    rows.push_back(limited(sensor_row(of, wall_name(wall), "sigma_over_theory", ratio, "1", n),
                           about(1, 0.05)));
  }
  double least = 0, most = 0;
  for (int i = 0; i < (quick ? 4 : 12); ++i) {
    const double bias_m =
        axis_bias_m(inputs_of({1 + 0.05 * i, 0, 0.5, 0, 0}, config, rng.fork("w")), config,
                    rng.fork("wiggle").fork(static_cast<std::uint64_t>(i)));
    least = std::min(least, bias_m);
    most = std::max(most, bias_m);
  }
  rows.push_back(sensor_row(of, "walls of 1 to 1.55 m", "wiggle", 0.5 * (most - least), "m", 12));
}

/// Errors of depth on a wall, and what the configuration's law says.
Spread structured_light_spread(const WallCase& wall, const StructuredLightConfig& config,
                               const Rng& rng) {
  const WallScene scene = make_wall(wall);
  const RayScene rays(scene.scene);
  const StructuredLightInputs inputs =
      structured_light_inputs(rays, scene.scene, scene.rig_from_world, config);
  const StructuredLightDepth depth = sense_structured_light(inputs, config, rng);
  const Camera camera = depth_camera(config);
  Spread spread;
  for (int y = config.rows / 4; y < 3 * config.rows / 4; ++y) {
    for (int x = config.columns / 4; x < 3 * config.columns / 4; ++x) {
      spread.asked += 1;
      if (depth.depth(x, y) == 0) continue;
      const auto z = static_cast<double>(inputs.depth_m(x, y));
      const Eigen::Vector3d ray((x - camera.cx_px) / camera.fx_px,
                                (y - camera.cy_px) / camera.fy_px, 1);
      const double theta = std::acos(
          std::clamp(-ray.normalized().dot(inputs.normal(x, y).cast<double>()), -1.0, 1.0));
      const double sigma_m = config.axial == AxialNoise::nguyen ? axial_sigma_m(config, z, theta)
                                                                : code_sigma_m(config, z);
      spread.add(depth.depth(x, y) * config.depth_unit_m - z, sigma_m);
    }
  }
  return spread;
}

void add_structured_light(const std::string& name, std::uint64_t seed, bool quick,
                          std::vector<ScoreRow>& rows) {
  const SensorRows of{name, seed};
  StructuredLightConfig config = structured_light_preset(name);
  const Rng rng = Rng(seed).fork("ranging").fork(name);
  std::vector<WallCase> walls = {
      {1.4, 0.5, 0.5, 0, 0}, {0.8, 0.3, 0.5, 0, 0}, {2, 0.2, 0.5, 0, 0}, {1, 0.9, 0.5, 0, 0}};
  if (quick) walls.resize(2);
  for (const AxialNoise axial : {AxialNoise::nguyen, AxialNoise::barron_malik}) {
    config.axial = axial;
    const std::string law = axial == AxialNoise::nguyen ? "Nguyen" : "Barron and Malik";
    for (const WallCase& wall : walls) {
      const Spread s = structured_light_spread(wall, config, rng.fork(law));
      const auto n = static_cast<std::int64_t>(s.n);
      const std::string where = law + ", " + wall_name(wall);
      rows.push_back(
          sensor_row(of, where, "fill", s.n / s.asked, "1", static_cast<std::int64_t>(s.asked)));
      rows.push_back(sensor_row(of, where, "sigma_z", s.sigma_m(), "m", n));
      // Turned walls hold all fractions of a code, so that rounding adds a twelfth of its square.
      const double ratio = s.sigma_m() / s.expected_m();
      rows.push_back(
          limited(sensor_row(of, where, "sigma_over_published", ratio, "1", n), about(1, 0.05)));
    }
  }
}

}  // namespace

std::vector<ScoreRow> ranging_rows(std::uint64_t seed, bool quick) {
  std::vector<ScoreRow> rows;
  for (const std::string& name : time_of_flight_preset_names())
    add_time_of_flight(name, seed, quick, rows);
  for (const std::string& name : structured_light_preset_names())
    add_structured_light(name, seed, quick, rows);
  return rows;
}

}  // namespace cousin
