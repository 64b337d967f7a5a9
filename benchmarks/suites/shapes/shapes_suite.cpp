#include "benchmarks/suites/shapes/shapes_suite.h"

#include <cmath>
#include <map>

#include "benchmarks/loop/perceive.h"
#include "benchmarks/loop/score_seeds.h"
#include "benchmarks/loop/seeds_run.h"
#include "benchmarks/loop/simulate.h"
#include "benchmarks/suites/shapes/shape_meshes.h"
#include "sim/geometry/mesh_io.h"
#include "sim/process/scratch_folder.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

constexpr const char* kShapesSuite = "shapes";
constexpr int kShapeRuns = 4;
constexpr double kMostHeightBias_m = 5e-5;
constexpr double kLeastCover = 0.90, kMostCover = 0.98;
constexpr double kMostWidthOfRmse = 4.7;
constexpr double kHalfWidth_sigmas = 1.96;  ///< of a 95 % interval

Grid shapes_grid(const ShapesSuiteConfig& config) {
  std::vector<std::string> names;
  for (const std::string_view name : shape_names()) names.emplace_back(name);
  Factor shapes{"shape", {}};
  for (const std::string& name : names) shapes.levels.push_back(Level{name});
  if (config.quick) return {{"quick_{shape}", {shapes, key_factor("views", {"24"})}}};
  return {{"{shape}_run{run}",
           {number_factor("run", 0, config.runs > 0 ? config.runs : kShapeRuns), shapes,
            key_factor("views", {"40"})}}};
}

ScoreFile run_shape_job(const ShapesSuiteConfig& suite, const GridJob& job) {
  const ScratchFolder scratch("cousin_shapes");
  const std::string shape = job.at("shape").word;
  const std::filesystem::path mesh = scratch.path() / (shape + ".ply");
  write_ply(mesh, shape_mesh(shape));
  std::vector<std::string> sets = job.sets;
  sets.push_back("specimen=mesh:" + mesh.string());
  sets.emplace_back("specimen_variation=0.08");
  sets.insert(sets.end(), suite.sets.begin(), suite.sets.end());
  const RunConfig config = seeds_run_config(sets);
  const int run = job.has("run") ? job.number("run") : 0;
  const SimulatedRun simulated = simulate(config, suite.seed, run, {});
  const StageClock clock("measure");
  const Estimate estimate =
      perceive(simulated.capture, seeds_pipeline(config), suite.seed, {}, 0, {});
  const double wall_s = clock.finish().wall_s;
  SeedsScoreLabels labels;
  labels.suite = kShapesSuite;
  labels.scene = labels.case_name = shape;
  labels.method = "ours";
  labels.run = "run" + std::to_string(run);
  labels.seed = suite.seed;
  labels.settings.views = config.scene.views();
  SeedsScores scores = score_run(simulated.truth, estimate, labels);
  ScoreFile file;
  file.scores = std::move(scores.rows);
  file.specimens = std::move(scores.specimens);
  for (SpecimenRow& row : file.specimens) row.cultivar = shape;
  ScoreRow seconds = labelled_row(labels);
  seconds.metric = "seconds.measure";
  seconds.unit = "s";
  seconds.value = seconds.wall_s = wall_s;
  seconds.n = config.scene.views();
  file.scores.push_back(std::move(seconds));
  return file;
}

/// Errors and intervals of one trait of one shape.
struct IntervalSum {
  double squares = 0, widths = 0;
  int n = 0, held = 0;
  void add(const SpecimenRow& row) {
    const double error = row.measured - row.truth, half = kHalfWidth_sigmas * row.sigma;
    squares += error * error;
    widths += 2 * half;
    held += std::abs(error) <= half ? 1 : 0;
    ++n;
  }
};

/// The shares of intervals that hold and the widths of these, with limits.
std::vector<ScoreRow> interval_rows(const std::vector<SpecimenRow>& specimens,
                                    const SeedsScoreLabels& labels) {
  std::vector<ScoreRow> rows;
  for (const std::string_view shape : shape_names()) {
    std::map<std::string, IntervalSum> sums;
    int n = 0, held = 0;
    for (const SpecimenRow& row : specimens) {
      if (row.cultivar != shape || row.status != ScoreStatus::ok || !(row.sigma > 0)) continue;
      sums[row.trait].add(row);
    }
    const auto add = [&](std::string metric, double value, int count, const ScoreLimit& limit) {
      ScoreRow row = labelled_row(labels);
      row.case_name = shape;
      row.method = "ours";
      row.metric = std::move(metric);
      row.unit = "1";
      row.value = value;
      row.n = count;
      rows.push_back(limited(std::move(row), limit));
    };
    for (const auto& [trait, sum] : sums) {
      n += sum.n;
      held += sum.held;
      if (trait == "length" || trait == "width" || trait == "height")
        add(trait + ".width_over_rmse", sum.widths / sum.n / std::sqrt(sum.squares / sum.n), sum.n,
            at_most(kMostWidthOfRmse));
    }
    if (n > 0)
      add("traits.coverage_95", static_cast<double>(held) / n, n,
          {.low = kLeastCover, .high = kMostCover});
  }
  return rows;
}

}  // namespace

std::vector<ShardJob> shapes_suite_jobs(const ShapesSuiteConfig& config) {
  std::vector<ShardJob> jobs;
  for (GridJob& place : jobs_of(shapes_grid(config))) {
    std::string key =
        std::string(COUSIN_VERSION) + "/shapes/" + std::to_string(config.seed) + "/" + place.name;
    for (const std::string& set : place.sets) key += "\n" + set;
    for (const std::string& set : config.sets) key += "\n" + set;
    jobs.push_back(
        shard_of(place, key, [config, place] { return to_json(run_shape_job(config, place)); }));
  }
  return jobs;
}

std::vector<ScoreRow> shapes_pooled_rows(const std::vector<SpecimenRow>& specimens,
                                         std::uint64_t seed) {
  SeedsScoreLabels labels;
  labels.suite = kShapesSuite;
  labels.scene = "pooled";
  labels.seed = seed;
  std::vector<ScoreRow> rows;
  for (ScoreRow& row : pooled_rows(specimens, labels)) {
    const bool is_shape = row.case_name != "all" && !row.case_name.empty();
    const bool is_bias = row.metric == "height.bias" && is_shape;
    const ScoreLimit within{.low = -kMostHeightBias_m, .high = kMostHeightBias_m};
    rows.push_back(is_bias ? limited(std::move(row), within) : std::move(row));
  }
  for (ScoreRow& row : interval_rows(specimens, labels)) rows.push_back(std::move(row));
  return rows;
}

}  // namespace cousin
