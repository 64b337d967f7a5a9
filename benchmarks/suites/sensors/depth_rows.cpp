#include "benchmarks/suites/sensors/depth_rows.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "benchmarks/suites/sensors/depth_model_fit.h"
#include "benchmarks/suites/sensors/infrared_noise.h"
#include "benchmarks/suites/sensors/sensor_row.h"
#include "sim/render/ray_scene.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

constexpr const char* kMainRig = "d457";

std::string metres(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f m", value);
  return text;
}
std::string degrees(double value_rad) {
  char text[32];
  std::snprintf(text, sizeof text, "%.0f deg", value_rad * 180 / M_PI);
  return text;
}

/// One camera under test.
struct Device {
  std::string name;
  ActiveStereoConfig config;
  ActiveStereoUnit unit;
  SensorRows rows;
  Rng rng{0};
  int frames = 4;
  double texture = 0;  ///< of the walls: a passive camera needs some
  double light = 0.02;

  WallScores look(const WallCase& wall, const std::string& purpose) const {
    const Rng own = rng.fork(purpose);
    return score_full_model(see_wall(wall, config, unit, own), config, unit, frames,
                            own.fork("sensor"));
  }
  ScoreRow row(const std::string& case_name, const std::string& metric, double value,
               const std::string& unit_name, std::int64_t n) const {
    return sensor_row(rows, case_name, metric, value, unit_name, n);
  }
};

Device make_device(const std::string& name, std::uint64_t seed, bool quick) {
  Device device{name, active_stereo_preset(name), {}, {name, seed}};
  device.rng = Rng(seed).fork("depth rows").fork(name);
  // The laws are those of the model: a unit's errors of calibration are another matter.
  device.config.focal_error = device.config.baseline_error = device.config.yaw_error_rad = 0;
  device.unit = make_active_stereo(device.config, device.rng.fork("unit"));
  device.frames = quick ? 2 : 6;
  if (!device.config.has_projector) {
    device.texture = 0.6;
    device.light = 1;
  }
  return device;
}

/// Slope of log sigma over log distance, least squares.
double fit_exponent(const std::vector<double>& z_m, const std::vector<double>& sigma_m) {
  const double n = static_cast<double>(z_m.size());
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (std::size_t i = 0; i < z_m.size(); ++i) {
    const double x = std::log(z_m[i]), y = std::log(sigma_m[i]);
    sx += x;
    sy += y;
    sxx += x * x;
    sxy += x * y;
  }
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

/// Walls at distances where the pattern is bright. The law is the matcher's: the limit is on what
/// is left of sigma without the rounding to the depth's unit, unit^2 / 12 (Sheppard's correction),
/// which is a fourth of the D435i's variance at the nearest wall; the exponent as handed over
/// stands beside. The noise goes with the fraction of the disparity as well, so each distance is
/// seen at a whole disparity and half-way between two: what goes as cos(2 pi d) is as much at all
/// of them.
void add_distance_rows(const Device& device, std::vector<ScoreRow>& rows) {
  const double nearest = least_depth_m(device.config);
  std::vector<double> distances, sigmas_m, matched_m;
  for (const double factor : {2.4, 3.4, 4.8, 6.8}) {
    for (const double fraction : {0.0, 0.5})
      distances.push_back(at_fraction_m(device.config, factor * nearest, fraction));
  }
  for (const double z : distances) {
    const WallScores s =
        device.look({z, 0, 0.5, device.light, device.texture}, "distance " + metres(z));
    const std::string name = "wall at " + metres(z);
    rows.push_back(device.row(name, "fill", s.fill, "1", s.pixels));
    rows.push_back(device.row(name, "sigma_z", s.sigma_m, "m", s.pixels));
    rows.push_back(device.row(name, "sigma_d", s.sigma_px, "px", s.pixels));
    rows.push_back(device.row(name, "spatial_d", s.spatial_px, "px", s.pixels));
    rows.push_back(device.row(name, "temporal_d", s.temporal_px, "px", s.pixels));
    rows.push_back(device.row(name, "bias_d", s.bias_px, "px", s.pixels));
    // Half of the matcher's window may hang over the border.
    const double window =
        0.5 * (device.config.match.census_width_px + device.config.match.block_px);
    rows.push_back(
        limited(device.row(name, "band_over_disparity", s.band_px - s.disparity_px, "px", s.pixels),
                about(0, window)));
    sigmas_m.push_back(s.sigma_m);
    const double unit = device.config.depth_unit_m;
    matched_m.push_back(std::sqrt(std::max(0.0, s.sigma_m * s.sigma_m - unit * unit / 12)));
  }
  rows.push_back(device.row("walls over distance", "sigma_z_exponent.with_rounding",
                            fit_exponent(distances, sigmas_m), "1", distances.size()));
  const double exponent = fit_exponent(distances, matched_m);
  rows.push_back(limited(
      device.row("walls over distance", "sigma_z_exponent", exponent, "1", distances.size()),
      about(2, 0.1)));
}

void add_light_rows(const Device& device, std::vector<ScoreRow>& rows) {
  const double z = 5 * least_depth_m(device.config);
  for (const double light : {0.0, 0.1, 1.0, 3.0}) {
    char name[64];
    std::snprintf(name, sizeof name, "wall at %s, light %.2g of sunlight", metres(z).c_str(),
                  light / 3);
    const WallScores s = device.look({z, 0, 0.5, light, device.texture}, name);
    rows.push_back(device.row(name, "fill", s.fill, "1", s.pixels));
    rows.push_back(device.row(name, "sigma_d", s.sigma_px, "px", s.pixels));
  }
}

void add_incidence_rows(const Device& device, std::vector<ScoreRow>& rows) {
  const double z = 3.5 * least_depth_m(device.config);
  for (const double incidence : {0.35, 0.7, 1.05}) {
    const WallScores s = device.look({z, incidence, 0.5, device.light, device.texture},
                                     "incidence " + degrees(incidence));
    const std::string name = "wall at " + metres(z) + ", turned " + degrees(incidence);
    rows.push_back(device.row(name, "fill", s.fill, "1", s.pixels));
    rows.push_back(device.row(name, "sigma_d", s.sigma_px, "px", s.pixels));
    // Users see an "egg carton" of some hundredths of a pixel; a tenth would be a defect.
    rows.push_back(
        limited(device.row(name, "ripple_d", s.ripple_px, "px", s.pixels), about(0, 0.1)));
  }
}

/// Just beyond the least depth a mode measures, just before it does not.
void add_mode_rows(const Device& device, std::vector<ScoreRow>& rows) {
  for (const double columns : device.config.mode_columns) {
    Device mode = device;
    mode.config.columns = static_cast<int>(columns);
    mode.unit = make_active_stereo(mode.config, device.rng.fork("unit"));
    mode.frames = 1;
    const double least = least_depth_m(mode.config);
    const std::string name = std::to_string(mode.config.columns) + " columns";
    rows.push_back(mode.row(name, "least_depth", least, "m", 1));
    const auto right = [&](double factor) {
      const WallScores s =
          mode.look({factor * least, 0, 0.5, device.light, device.texture}, "mode " + name);
      return std::pair(s.fill * (1 - s.wrong), s.pixels);
    };
    const auto [beyond, n] = right(1.05);
    const auto [before, m] = right(0.97);
    rows.push_back(
        limited(mode.row(name, "right_beyond_least_depth", beyond, "1", n), at_least(0.9)));
    rows.push_back(
        limited(mode.row(name, "right_before_least_depth", before, "1", m), at_most(0.05)));
  }
}

void add_edge_rows(const Device& device, std::vector<ScoreRow>& rows) {
  const PlateEdges edges = plate_edges(device.config, device.unit, device.rng.fork("plate"));
  const double half_window =
      0.5 * (device.config.match.census_width_px + device.config.match.block_px - 1);
  rows.push_back(limited(device.row("plate before a wall", "growth", edges.growth_px, "px", 4),
                         about(0, half_window)));
  rows.push_back(device.row("plate before a wall", "rim_without_depth", edges.rim_px, "px", 4));
}

/// Walls between those that the fast model was fitted to.
void add_model_rows(const Device& device, bool quick, std::vector<ScoreRow>& rows) {
  std::vector<WallCase> walls = test_walls(device.config);
  if (quick) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < walls.size(); i += 3) walls[kept++] = walls[i];
    walls.resize(kept);
  }
  const auto compared =
      compare_models(walls, device.config, device.unit, quick ? 2 : 4, device.rng.fork("models"));
  double ratio_squares = 0, ratios = 0, fill_squares = 0;
  for (const ModelComparison& c : compared) {
    char name[96];
    std::snprintf(name, sizeof name, "fast model, wall at %s, %s, light %.2g of sunlight",
                  metres(c.wall.distance_m).c_str(), degrees(c.wall.incidence_rad).c_str(),
                  c.wall.light / 3);
    const double difference = c.fast.fill - c.full.fill;
    fill_squares += difference * difference;
    rows.push_back(limited(device.row(name, "fill_difference", difference, "1", c.full.pixels),
                           about(0, 0.02)));
    if (c.full.fill < 0.1 || c.fast.fill < 0.1) continue;  // too few to tell a spread
    const double ratio = c.fast.sigma_px / c.full.sigma_px;
    ratio_squares += std::pow(std::log(ratio), 2);
    ratios += 1;
    rows.push_back(
        limited(device.row(name, "sigma_ratio", ratio, "1", c.full.pixels), between(0.9, 1.1)));
  }
  const auto n = static_cast<double>(compared.size());
  rows.push_back(limited(device.row("fast model, all walls", "sigma_ratio_rms",
                                    std::sqrt(ratio_squares / std::max(ratios, 1.0)), "1", n),
                         at_most(0.1)));
  rows.push_back(limited(device.row("fast model, all walls", "fill_difference_rms",
                                    std::sqrt(fill_squares / n), "1", n),
                         at_most(0.02)));
}

/// Images a second, with the seconds of one image by the clock and by all processors.
template <class Work>
ScoreRow speed_row(const Device& device, const std::string& case_name, int images, double least,
                   const Work& work) {
  work(0);  // tables and memory
  const StageClock clock(case_name);
  for (int i = 1; i <= images; ++i) work(i);
  const StageTiming timing = clock.finish();
  ScoreRow row = device.row(case_name, "images_per_second", images / timing.wall_s, "1/s", images);
  row.wall_s = timing.wall_s / images;
  row.cpu_s = timing.cpu_s / images;
  return limited(row, at_least(least));
}

void add_speed_rows(const Device& device, bool quick, std::vector<ScoreRow>& rows) {
  const WallScene wall = make_wall({1.2, 0.3, 0.5, device.light, device.texture});
  const RayScene rays(wall.scene);
  const int images = quick ? 2 : 5;
  rows.push_back(speed_row(device, "rendered, matched, registered", images, 0.5, [&](int i) {
    const InfraredPair pair = render_infrared_pair(rays, wall.scene, wall.rig_from_world,
                                                   device.config, device.unit, Rng(1));
    const StereoDepth depth = sense_depth(pair, device.config, device.unit, Rng(2 + i));
    register_to_color(depth.depth, device.config, device.unit);
  }));
  // Of the sensor's variance at most a quarter, as the budget of the pair's rendering says.
  const double share = render_noise_share({1.2, 0.3, 0.5, device.light, device.texture},
                                          device.config, device.unit, device.rng.fork("variance"));
  rows.push_back(limited(device.row("infrared pair", "render_variance_over_sensor", share, "1",
                                    static_cast<std::int64_t>(device.unit.imager.width_px) *
                                        device.unit.imager.height_px),
                         at_most(0.25)));
  DepthModelInputs inputs;
  rows.push_back(speed_row(device, "fast model and its rendering", 4 * images, 5, [&](int i) {
    inputs = depth_model_inputs(rays, wall.scene, wall.rig_from_world, device.config, device.unit,
                                Rng(1));
    model_depth(inputs, device.config, Rng(3), Rng(4 + i));
  }));
  rows.push_back(speed_row(device, "fast model", 4 * images, 20,
                           [&](int i) { model_depth(inputs, device.config, Rng(3), Rng(4 + i)); }));
}

}  // namespace

std::vector<ScoreRow> depth_rows_of(const std::string& rig, std::uint64_t seed, bool quick) {
  std::vector<ScoreRow> rows;
  const Device device = make_device(rig, seed, quick);
  const bool is_main = rig == kMainRig;
  add_distance_rows(device, rows);
  add_mode_rows(device, rows);
  add_edge_rows(device, rows);
  if (quick && !is_main) return rows;
  add_light_rows(device, rows);
  add_incidence_rows(device, rows);
  add_model_rows(device, quick, rows);
  return rows;
}

std::vector<ScoreRow> depth_speed_rows(std::uint64_t seed, bool quick) {
  std::vector<ScoreRow> rows;
  add_speed_rows(make_device(kMainRig, seed, quick), quick, rows);
  return rows;
}

}  // namespace cousin
