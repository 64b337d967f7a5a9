#include "benchmarks/suites/render/render_suite.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <variant>
#include <vector>

#include "benchmarks/loop/seeds_run.h"
#include "benchmarks/suites/render/cached_light.h"
#include "benchmarks/suites/render/corner_position.h"
#include "benchmarks/suites/render/leaf_cloud.h"
#include "benchmarks/suites/render/leave_out.h"
#include "benchmarks/suites/seeds/render_noise.h"
#include "benchmarks/suites/stability/truth_throughput.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

ScoreRow row_of(const std::string& case_name, const std::string& metric, double value,
                const std::string& unit, std::int64_t n, std::uint64_t seed) {
  ScoreRow row;
  row.suite = "render";
  row.scene = "seeds";
  row.case_name = case_name;
  row.method = "ours";
  row.metric = metric;
  row.value = value;
  row.unit = unit;
  row.n = n;
  row.seed = seed;
  row.peak_rss_mb = peak_rss_mb();
  row.peak_above_start_mb = row.peak_rss_mb - start_rss_mb();
  return row;
}

/// Truth of many instanced triangles: images a second by the clock, and seconds of all cores
/// together, alone and against Embree's packets, which another load of the machine changes less.
void add_leaf_cloud_rows(std::vector<ScoreRow>& rows, std::uint64_t seed, bool quick) {
  const auto add = [&](const std::string& name, const std::string& metric, double value,
                       const std::string& unit, std::int64_t n, double limit, bool is_upper) {
    ScoreRow row = row_of(name, metric, value, unit, n, seed);
    row.scene = "leaf cloud";
    const bool is_held = !std::isnan(limit) && !std::isnan(value);
    rows.push_back(is_held ? limited(row, is_upper ? at_most(limit) : at_least(limit)) : row);
  };
  constexpr double kShown = std::numeric_limits<double>::quiet_NaN();
  const LeafCloudSpeed speed = measure_leaf_cloud({}, quick ? 5 : 15);
  const std::int64_t n = speed.triangles;
  add("Embree's packets alone", "images_per_second", 1 / speed.raw.wall_s, "1/s", n, kShown, false);
  struct Case {
    const char* name;
    ImageSeconds seconds;
    double least;
  };
  for (const Case& c : {Case{"depth, normals, ids", speed.centres, 15},
                        Case{"with masks of 50 instances", speed.masks, 6},
                        Case{"with areas by 4 samples", speed.shares, 4}}) {
    const std::string name = std::string("truth pass, ") + c.name;
    add(name, "images_per_second", 1 / c.seconds.wall_s, "1/s", n, c.least, false);
    add(name, "cpu_seconds.image", c.seconds.cpu_s, "s", n, kShown, false);
    add(name, "share_of_raw", speed.raw.cpu_s / c.seconds.cpu_s, "1", n, kShown, false);
  }
  // 12 500 leaves of 250 models of 800 triangles, and 10 leaves of 500 000 triangles each.
  add("10 M instanced triangles of 200 k", "peak_above_start",
      leaf_cloud_memory_mb({.leaves = 12500, .models = 250}), "MB", 10'000'000, 200, true);
  add("5 M unique triangles", "peak_above_start",
      leaf_cloud_memory_mb({.leaves = 10, .models = 10, .cells = 500, .specimens = 2}), "MB",
      5'000'000, 1000, true);
}

/// Passes with and without, in one process: a run that reads depth alone, or colour alone, of a rig
/// that has both.
void add_leave_out_rows(std::vector<ScoreRow>& rows, std::uint64_t seed, bool quick) {
  const int measured = quick ? 3 : 9;
  const LeaveOutSeconds seconds = measure_leave_out(seed, measured);
  const std::string name =
      "leaving out, d457, " + std::to_string(seconds.views) + " views of the sphere";
  const auto add = [&](const char* metric, double value) {
    rows.push_back(row_of(name, metric, value, "s", measured, seed));
  };
  add("seconds.light_cache", seconds.light_cache_s);
  add("seconds.view.colour", seconds.color_s);
  add("seconds.view.depth_matched", seconds.depth_matched_s);
  add("seconds.view.depth_model", seconds.depth_model_s);
  add("seconds.capture.depth_only", seconds.depth_only_s());
  add("seconds.capture.depth_and_colour", seconds.everything_s());
  add("seconds_saved.no_light", seconds.everything_s() - seconds.depth_only_s());
  add("seconds_saved.no_infrared_and_depth", seconds.views * seconds.depth_matched_s);
}

/// Measures one view of each camera ring: the higher the ring, the more rays hit the board.
void add_throughput_rows(std::vector<ScoreRow>& rows, const Simulation& simulation,
                         const PhoneConfig& phone, std::uint64_t seed, bool quick) {
  const int views = static_cast<int>(simulation.views().size());
  for (const int view : {views / 6, views / 2, 5 * views / 6}) {
    const TruthThroughput t = measure_truth_throughput(
        simulation.rays(), simulation.scene(), simulation.views()[static_cast<std::size_t>(view)],
        quick ? 7 : 21);
    const std::string name = "truth pass, view " + std::to_string(view);
    const std::int64_t rays = static_cast<std::int64_t>(phone.width_px) * phone.height_px;
    rows.push_back(row_of(name, "raw_rays_per_second", t.raw_rays_per_s, "1/s", rays, seed));
    rows.push_back(row_of(name, "truth_rays_per_second", t.truth_rays_per_s, "1/s", rays, seed));
    rows.push_back(limited(row_of(name, "share_of_raw", t.share, "1", rays, seed), at_least(0.6)));
  }
}

void add_radiance_rows(std::vector<ScoreRow>& rows, const Simulation& simulation,
                       std::uint64_t seed, bool quick) {
  const int views = static_cast<int>(simulation.views().size());
  const StageClock first_clock("first");
  simulation.radiance(0);
  const double first_s = first_clock.finish().wall_s;
  std::vector<double> seconds;
  for (int i = 0; i < (quick ? 2 : 6); ++i) {
    const StageClock clock("view");
    simulation.radiance(i * views / 6);
    seconds.push_back(clock.finish().wall_s);
  }
  std::sort(seconds.begin(), seconds.end());
  const double median_s = seconds[seconds.size() / 2];
  rows.push_back(row_of("radiance pass", "seconds.view", median_s, "s",
                        static_cast<std::int64_t>(seconds.size()), seed));
  rows.push_back(row_of("radiance pass", "seconds.light_cache", std::max(0.0, first_s - median_s),
                        "s", 1, seed));
}

void add_noise_rows(std::vector<ScoreRow>& rows, const Simulation& simulation,
                    const PhoneConfig& phone, std::uint64_t seed, bool quick) {
  const int views = static_cast<int>(simulation.views().size());
  for (const int view : quick ? std::vector<int>{views / 2}
                              : std::vector<int>{views / 6, views / 2, 5 * views / 6}) {
    const RenderNoise noise = measure_render_noise(simulation, phone, view);
    const std::string name = "Monte-Carlo noise, view " + std::to_string(view);
    rows.push_back(limited(row_of(name, "mean_variance_over_sensor_variance", noise.mean_ratio, "1",
                                  noise.pixels, seed),
                           at_most(0.25)));
    rows.push_back(row_of(name, "median_variance_over_sensor_variance", noise.median_ratio, "1",
                          noise.pixels, seed));
  }
}

void add_cached_light_rows(std::vector<ScoreRow>& rows, const Simulation& simulation,
                           int max_bounces, std::uint64_t seed, bool quick) {
  const int views = static_cast<int>(simulation.views().size());
  for (const CachedLightError& e :
       compare_cached_light(simulation, views / 2, quick ? 16 : 64, max_bounces + 1)) {
    const std::string name = "cached light against paths, " + e.category;
    rows.push_back(row_of(name, "mean_ratio", e.mean_ratio, "1", e.pixels, seed));
    rows.push_back(row_of(name, "rms", e.rms, "1", e.pixels, seed));
  }
}

void add_corner_rows(std::vector<ScoreRow>& rows, std::uint64_t seed) {
  for (const LensModel model :
       {LensModel::pinhole, LensModel::opencv5, LensModel::opencv8, LensModel::opencv12,
        LensModel::kannala_brandt4, LensModel::splined_stereographic}) {
    const CornerPositions found = measure_corner_positions(model);
    const std::string name = "board corners, " + std::string(to_string(model));
    rows.push_back(
        limited(row_of(name, "corner.bias", found.bias_px.norm(), "px", found.corners, seed),
                at_most(0.02)));
    rows.push_back(row_of(name, "corner.rms", found.rms_px, "px", found.corners, seed));
  }
}

}  // namespace

ScoreFile render_suite(std::uint64_t seed, const std::vector<std::string>& sets, bool quick,
                       const Progress& progress) {
  const auto say = [&](const std::string& what, int done, int total) {
    if (progress) progress(what, done, total);
  };
  ScoreFile file;
  const RunConfig config = seeds_run_config(sets);
  const auto* phone = std::get_if<PhoneConfig>(&config.rig);
  if (!phone) {
    throw std::invalid_argument("bench render measures a phone's views; rig " + config.scene.rig() +
                                " is none");
  }
  say("scene", 0, 8);
  const StageClock scene_clock("scene");
  const Simulation simulation(config, seed, 0);
  const StageTiming scene = scene_clock.finish();
  file.scores.push_back(row_of("seeds scene", "seconds.scene", scene.wall_s, "s", 1, seed));
  say("truth throughput", 1, 8);
  add_throughput_rows(file.scores, simulation, *phone, seed, quick);
  say("radiance", 2, 8);
  add_radiance_rows(file.scores, simulation, seed, quick);
  say("noise", 3, 8);
  add_noise_rows(file.scores, simulation, *phone, seed, quick);
  say("cached light", 4, 8);
  add_cached_light_rows(file.scores, simulation, config.cached.max_bounces, seed, quick);
  say("corners", 5, 8);
  add_corner_rows(file.scores, seed);
  say("leaf cloud", 6, 8);
  add_leaf_cloud_rows(file.scores, seed, quick);
  say("what leaving out saves", 7, 8);
  add_leave_out_rows(file.scores, seed, quick);
  return file;
}

}  // namespace cousin
