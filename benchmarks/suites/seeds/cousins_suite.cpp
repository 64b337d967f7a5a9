#include "benchmarks/suites/seeds/cousins_suite.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <functional>

#include "benchmarks/loop/perceive.h"
#include "benchmarks/loop/plan.h"
#include "benchmarks/loop/score_seeds.h"
#include "benchmarks/loop/seeds_run.h"
#include "benchmarks/study/shard_scores.h"
#include "benchmarks/suites/seeds/capture_store.h"
#include "perception/cloud/measure_traits.h"
#include "sim/types/trait_table.h"

namespace cousin {
namespace {

constexpr const char* kSuite = "cousins";
constexpr const char* kTwin = "twin";

/// The twin is a point of all axes.
Factor points_of(bool quick) {
  const std::vector<const char*> distances =
      quick ? std::vector<const char*>{"0.5", "1"} : std::vector{"0.25", "0.5", "0.75", "1"};
  Factor point{"point", {{kTwin}}};
  for (const std::string& axis : cousin_axes()) {
    for (const std::string distance : distances)
      point.levels.push_back({axis + " " + distance, {"cousin." + axis + "=" + distance}});
  }
  return point;
}

Grid cousins_grid(const CousinsSuiteConfig& suite) {
  return {{"{point}_run{run}",
           {number_factor("run", 0, suite.quick ? 1 : suite.runs), points_of(suite.quick)}}};
}

/// @param point  its keys, after the user's
RunConfig job_config(const CousinsSuiteConfig& suite, const std::vector<std::string>& point) {
  std::vector<std::string> sets = {"rig=phone_video_720p", "views=60"};
  if (suite.quick)
    sets = {"rig=phone_video_720p", "views=20", "rig.width_px=960", "rig.height_px=540"};
  sets.insert(sets.end(), suite.sets.begin(), suite.sets.end());
  sets.insert(sets.end(), point.begin(), point.end());
  return seeds_run_config(sets);
}

struct Job {
  GridJob grid;
  RunConfig config;

  int run() const { return grid.number("run"); }
  const std::string& point() const { return grid.at("point").word; }  ///< "shape 0.25"
};

std::string run_job(const Job& job, std::uint64_t seed, const Progress& progress) {
  const SimulatedRun run =
      simulate(job.config, seed, job.run(), planned_truth(SeedsPipelineConfig(), false), progress);
  const std::uint64_t stage_seed = Rng(seed).fork(static_cast<std::uint64_t>(job.run()))();
  const Estimate estimate =
      perceive(run.capture, seeds_pipeline(job.config), stage_seed, {}, job.run(), {}, progress);
  SeedsScoreLabels labels;
  labels.suite = kSuite;
  labels.scene = seeds_scene(job.config).cultivar;
  labels.case_name = job.point() + " run " + std::to_string(job.run());
  labels.run = std::to_string(job.run());
  labels.seed = seed;
  SeedsScores scores = score_run(run.truth, estimate, labels);
  for (SpecimenRow& row : scores.specimens) row.dataset = job.point();
  ScoreFile file;
  file.header.program_version = COUSIN_VERSION;
  file.header.config_hash = config_hash(job.config, seed);
  file.scores = std::move(scores.rows);
  file.specimens = std::move(scores.specimens);
  return to_json(file);
}

ScoreRow base_row(const std::string& point, const CousinsSuiteConfig& config) {
  ScoreRow row;
  row.suite = kSuite;
  row.scene = "pooled";
  row.case_name = point;
  row.method = "ours";
  row.seed = config.seed;
  return row;
}

/// Mean seconds of measuring one capture of the point, largest memory.
void add_run_times(const std::vector<ScoreRow>& of_jobs, const std::string& point, ScoreRow& row) {
  double wall_s = 0, cpu_s = 0, peak_mb = 0;
  int count = 0;
  for (const ScoreRow& job : of_jobs) {
    if (job.metric != "seconds.perceive" || !job.case_name.starts_with(point + " run ")) continue;
    wall_s += job.wall_s;
    cpu_s += job.cpu_s;
    peak_mb = std::max(peak_mb, job.peak_rss_mb);
    ++count;
  }
  if (count == 0) return;
  row.wall_s = wall_s / count;
  row.cpu_s = cpu_s / count;
  row.peak_rss_mb = peak_mb;
}

void add_point_rows(const std::vector<SpecimenRow>& all, const std::string& point,
                    const CousinsSuiteConfig& config, std::vector<ScoreRow>& rows) {
  std::vector<SpecimenRow> own;
  for (const SpecimenRow& row : all) {
    if (row.dataset == point) own.push_back(row);
  }
  if (own.empty()) return;
  ScoreRow base = base_row(point, config);
  add_run_times(rows, point, base);
  for (const std::string_view trait : kSeedTraits) {
    const auto pairs = trait_pairs(own, trait, [](const SpecimenRow&) { return true; });
    if (pairs.size() < 2) continue;
    const TraitStatistics s =
        trait_statistics(pairs, Rng(config.seed).fork("cousins").fork(point).fork(trait));
    const std::string name(trait), unit(trait_row(trait).unit);
    rows.push_back(with_interval(base, name + ".rmse", unit, s.rmse, s.n));
    rows.push_back(with_interval(base, name + ".mape", "1", s.mape, s.n));
    rows.push_back(with_interval(base, name + ".bias", unit, s.bias, s.n));
  }
  // One row of a trait stands for each true specimen.
  std::int64_t asked = 0, measured = 0;
  for (const SpecimenRow& row : own) {
    if (row.trait != kSeedTraits[0]) continue;
    ++asked;
    measured += row.status == ScoreStatus::ok;
  }
  if (asked == 0) return;
  ScoreRow row = base;
  row.metric = "specimens.measured";
  row.unit = "1";
  row.value = static_cast<double>(measured) / static_cast<double>(asked);
  row.n = asked;
  rows.push_back(std::move(row));
}

/// A metric over the distance along each axis, beginning at the twin.
LinePlot plot_of(const std::vector<ScoreRow>& rows, const std::string& metric,
                 const std::string& title, const std::string& y_label, double scale) {
  LinePlot plot;
  plot.section = "Along the axes of distance";
  plot.title = title;
  plot.caption = {"Each axis alone; 0 is the reference scene, 1 as far as its table goes."};
  plot.x_label = "distance from the reference";
  plot.y_label = y_label;
  for (const std::string& axis : cousin_axes()) {
    LineSeries series;
    series.name = axis;
    for (const ScoreRow& row : rows) {
      if (row.suite != kSuite || row.scene != "pooled" || row.metric != metric) continue;
      const bool is_own = row.case_name.starts_with(axis + " ");
      if (!is_own && row.case_name != kTwin) continue;
      const double x = is_own ? std::strtod(row.case_name.c_str() + axis.size(), nullptr) : 0;
      series.points.push_back({x, {scale * row.value, scale * row.ci_low, scale * row.ci_high}});
    }
    std::sort(series.points.begin(), series.points.end(),
              [](const PlotPoint& a, const PlotPoint& b) { return a.x < b.x; });
    if (series.points.size() > 1) plot.series.push_back(std::move(series));
  }
  return plot;
}

}  // namespace

std::vector<ShardJob> cousins_suite_jobs(const CousinsSuiteConfig& config,
                                         const Progress& progress) {
  std::vector<ShardJob> jobs;
  for (GridJob& place : jobs_of(cousins_grid(config))) {
    const Job job{place, job_config(config, place.sets)};
    const std::string key = std::string(COUSIN_VERSION) + resolved_toml(job.config) +
                            describe(cousin_moves(seeds_row().defaults())) +
                            std::to_string(config.seed) + "/" + std::to_string(job.run()) +
                            user_files_hash(job.config.scene) + built_in_tables();
    jobs.push_back(shard_of(std::move(place), key, [job, seed = config.seed, progress] {
      return run_job(job, seed, progress);
    }));
  }
  return jobs;
}

ScoreFile pool_cousins_suite(const std::vector<ShardResult>& results,
                             const CousinsSuiteConfig& config) {
  ScoreFile pooled = scores_of_shards(results, kSuite, config.seed);
  pooled.header.program_version = COUSIN_VERSION;
  for (const Level& point : points_of(config.quick).levels)
    add_point_rows(pooled.specimens, point.word, config, pooled.scores);
  return pooled;
}

std::vector<LinePlot> cousins_plots(const std::vector<ScoreRow>& rows) {
  std::vector<LinePlot> plots;
  const auto add = [&](LinePlot plot) {
    if (!plot.series.empty()) plots.push_back(std::move(plot));
  };
  for (const std::string_view trait : kSeedTraits) {
    const std::string name(trait);
    const TraitRow& shown = trait_row(trait);
    add(plot_of(rows, name + ".rmse", "RMSE of " + name + " over the distance",
                "RMSE of " + name + " (" + std::string(shown.shown) + ")", shown.factor));
  }
  add(plot_of(rows, "specimens.measured", "Specimens measured over the distance",
              "share of the specimens measured", 1));
  return plots;
}

std::string cousins_toml(const CousinsSuiteConfig& config) {
  std::string text = "# twin\n" + resolved_toml(job_config(config, {})) + "\n# All jobs: --seed " +
                     std::to_string(config.seed) + "\n# At 1, cousin.AXIS moves\n";
  std::string moves = describe(cousin_moves(seeds_row().defaults()));
  for (std::size_t at = 0; at < moves.size();) {
    const std::size_t end = moves.find('\n', at);
    text += "#   " + moves.substr(at, end - at) + "\n";
    at = end + 1;
  }
  return text;
}

}  // namespace cousin
