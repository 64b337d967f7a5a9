#include "benchmarks/suites/shapes/shapes_suite.h"

#include "benchmarks/loop/perceive.h"
#include "benchmarks/loop/score_geometry.h"
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
  file.scores.push_back(seconds_row(labels, wall_s, config.scene.views()));
  return file;
}

/// The shares of intervals that hold and the widths of these, with limits.
std::vector<ScoreRow> interval_rows(const std::vector<SpecimenRow>& specimens,
                                    const SeedsScoreLabels& labels) {
  std::vector<ScoreRow> rows;
  for (const std::string_view shape : shape_names()) {
    ScoreRow base = labelled_row(labels);
    base.case_name = shape;
    base.method = "ours";
    std::vector<TraitPair> of_all;
    for (const std::string_view trait : kSeedTraits) {
      const std::vector<TraitPair> pairs = trait_pairs(
          specimens, trait, [&](const SpecimenRow& row) { return row.cultivar == shape; });
      of_all.insert(of_all.end(), pairs.begin(), pairs.end());
      if (trait == "area" || trait == "volume") continue;
      const SigmaCoverage own = sigma_coverage(pairs);
      if (own.n > 0)
        rows.push_back(limited(measured_row(base, std::string(trait) + ".width_over_rmse",
                                            own.width_over_rmse, "1", own.n),
                               at_most(kMostWidthOfRmse)));
    }
    const SigmaCoverage all = sigma_coverage(of_all);
    if (all.n > 0)
      rows.push_back(limited(with_interval(base, "traits.coverage_95", "1", all.within_95, all.n),
                             {.low = kLeastCover, .high = kMostCover}));
  }
  return rows;
}

}  // namespace

std::vector<ShardJob> shapes_suite_jobs(const ShapesSuiteConfig& config) {
  return shards_of(
      shapes_grid(config), std::string(COUSIN_VERSION) + "/shapes/" + std::to_string(config.seed),
      config.sets, [config](const GridJob& job) { return to_json(run_shape_job(config, job)); });
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
