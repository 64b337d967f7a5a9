#include "benchmarks/render/render_suite.h"

#include <algorithm>
#include <vector>

#include "benchmarks/render/corner_position.h"
#include "benchmarks/seeds/render_noise.h"
#include "benchmarks/stability/truth_throughput.h"
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

ScoreRow limited(ScoreRow row, bool passes) {
  row.status = passes ? ScoreStatus::pass : ScoreStatus::fail;
  return row;
}

}  // namespace

ScoreFile render_suite(std::uint64_t seed, const std::vector<std::string>& sets, bool quick,
                       const Progress& progress) {
  const auto say = [&](const std::string& what, int done, int total) {
    if (progress) progress(what, done, total);
  };
  ScoreFile file;
  const SeedsRunConfig config = seeds_run_config(sets);
  say("scene", 0, 5);
  const StageClock scene_clock("scene");
  const SeedsSimulation simulation(config, seed, 0);
  const StageTiming scene = scene_clock.finish();
  file.scores.push_back(row_of("seeds scene", "seconds.scene", scene.wall_s, "s", 1, seed));

  say("truth throughput", 1, 5);
  // A view of each ring: the share of rays that hit the board changes with elevation.
  const int views = static_cast<int>(simulation.views().size());
  std::vector<double> shares;
  for (const int view : {views / 6, views / 2, 5 * views / 6}) {
    const TruthThroughput t = measure_truth_throughput(
        simulation.rays(), simulation.scene(), simulation.views()[static_cast<std::size_t>(view)],
        quick ? 7 : 21);
    const std::string name = "truth pass, view " + std::to_string(view);
    const std::int64_t rays = static_cast<std::int64_t>(config.rig.width_px) * config.rig.height_px;
    file.scores.push_back(row_of(name, "raw_rays_per_second", t.raw_rays_per_s, "1/s", rays, seed));
    file.scores.push_back(
        row_of(name, "truth_rays_per_second", t.truth_rays_per_s, "1/s", rays, seed));
    file.scores.push_back(
        limited(row_of(name, "share_of_raw", t.share, "1", rays, seed), t.share >= 0.6));
  }

  say("radiance", 2, 5);
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
  file.scores.push_back(row_of("radiance pass", "seconds.view", median_s, "s",
                               static_cast<std::int64_t>(seconds.size()), seed));
  file.scores.push_back(row_of("radiance pass", "seconds.light_cache",
                               std::max(0.0, first_s - median_s), "s", 1, seed));

  say("noise", 3, 5);
  for (const int view : quick ? std::vector<int>{views / 2}
                              : std::vector<int>{views / 6, views / 2, 5 * views / 6}) {
    const RenderNoise noise = measure_render_noise(simulation, config.rig, view);
    const std::string name = "Monte-Carlo noise, view " + std::to_string(view);
    file.scores.push_back(limited(row_of(name, "mean_variance_over_sensor_variance",
                                         noise.mean_ratio, "1", noise.pixels, seed),
                                  noise.mean_ratio <= 0.25));
    file.scores.push_back(row_of(name, "median_variance_over_sensor_variance", noise.median_ratio,
                                 "1", noise.pixels, seed));
  }

  say("corners", 4, 5);
  for (const LensModel model :
       {LensModel::pinhole, LensModel::opencv5, LensModel::opencv8, LensModel::opencv12,
        LensModel::kannala_brandt4, LensModel::splined_stereographic}) {
    const CornerPositions found = measure_corner_positions(model);
    const std::string name = "board corners, " + std::string(to_string(model));
    file.scores.push_back(
        limited(row_of(name, "corner.bias", found.bias_px.norm(), "px", found.corners, seed),
                found.bias_px.norm() <= 0.02));
    file.scores.push_back(row_of(name, "corner.rms", found.rms_px, "px", found.corners, seed));
  }
  return file;
}

}  // namespace cousin
