#include "benchmarks/suites/strawberries/strawberries_suite.h"

#include <algorithm>
#include <optional>

#include "benchmarks/suites/fruits/fruit_suite.h"
#include "perception/pipelines/strawberries.h"
#include "scenes/strawberries/strawberries_scene.h"

namespace cousin {
namespace {

constexpr int kRuns = 10;
constexpr std::string_view kPlain = "bed";

/// Cameras on the same plants; the usual jobs are by the D457 at 640 columns.
const std::vector<Level>& cameras() {
  static const std::vector<Level> kCameras = {{"d405", {"rig=d405"}},
                                              {"d435i", {"rig=d435i"}},
                                              {"d457-848", {"rig=d457", "rig.columns=848"}},
                                              {"d457-1280", {"rig=d457", "rig.columns=1280"}},
                                              {"kinect-v2", {"rig=kinect_v2"}}};
  return kCameras;
}

Grid strawberries_grid(const StrawberriesSuiteConfig& config) {
  const int runs = config.runs > 0 ? config.runs : config.quick ? 1 : kRuns;
  const std::string quick = config.quick ? "quick_" : "";
  const auto block = [&](const std::string& name, int count, std::vector<Factor> own) {
    std::vector<Factor> factors = {number_factor("run", 0, count),
                                   key_factor("views", {config.quick ? "3" : "6"})};
    // The fast model is of cameras with a projector.
    if (config.quick && !name.starts_with("camera"))
      factors.push_back(key_factor("depth_by", {"model"}));
    factors.insert(factors.end(), own.begin(), own.end());
    return GridBlock{quick + name, factors};
  };
  const int third = std::max(1, runs / 3);
  return {block("bed_run{run}", runs, {}),
          block("family_run{run}", third, {key_factor("family", {"harmonics"})}),
          block("near_run{run}", 1,
                {key_factor("distance_min_m", {"0.15"}), key_factor("distance_max_m", {"0.3"})}),
          block("camera_{camera}_run{run}", third, {Factor{"camera", cameras()}})};
}

/// What ours aims at: preset's unit, true boxes and masks.
std::optional<ScoreLimit> limit_of(const ScoreRow& row) {
  struct Aim {
    const char* case_name;
    const char* metric;
    ScoreLimit limit;
  };
  static const Aim kAims[] = {{"all", "point.rmse_x", at_most(0.001)},
                              {"all", "point.rmse_y", at_most(0.001)},
                              {"all", "point.rmse_z", at_most(0.0015)},
                              {"all", "centre.rmse_3d", at_most(0.002)},
                              {"all", "volume.mape", at_most(0.09)},
                              {"unoccluded", "cut.error_lateral", at_most(0.003)},
                              {"unoccluded", "cut.error_3d", at_most(0.006)},
                              {"hidden below 30 %", "cut.error_lateral", at_most(0.003)},
                              {"hidden below 30 %", "cut.error_3d", at_most(0.006)},
                              {"hidden 30 to 50 %", "cut.error_lateral", at_most(0.003)},
                              {"hidden 30 to 50 %", "cut.error_3d", at_most(0.006)},
                              {"all", "volume.coverage_95", between(0.92, 0.97)},
                              {"all", "volume.width_over_rmse", at_most(4.7)},
                              {"all", "volume.rmse_by_width", at_least(1.5)},
                              {"all", "volume.measured", at_least(0.8)},
                              {"family, all", "volume.coverage_95", between(0.90, 0.98)}};
  if (row.method != "ours") return std::nullopt;
  for (const Aim& aim : kAims) {
    if (row.case_name == aim.case_name && row.metric == aim.metric) return aim.limit;
  }
  return std::nullopt;
}

std::string scene_of(const GridJob& job) {
  if (job.has("camera")) return job.at("camera").word;
  if (job.has("family")) return "family";
  return job.has("distance_min_m") ? "near" : std::string(kPlain);
}

FruitSuite suite_of(std::uint64_t seed, std::vector<std::string> sets) {
  return {.name = "strawberries",
          .scene = &strawberries_row,
          .pipeline = [] { return PipelineConfig(StrawberriesPipelineConfig{}); },
          .seed = seed,
          .sets = std::move(sets),
          .plain = kPlain,
          .scene_of = &scene_of,
          .traits = {"length", "diameter", "volume", "red_share"},
          .fruits_timed = 10,
          .limit_s = 0.015,
          .limit = &limit_of};
}

}  // namespace

std::vector<ShardJob> strawberries_suite_jobs(const StrawberriesSuiteConfig& config) {
  return shards_of(strawberries_grid(config),
                   std::string(COUSIN_VERSION) + "/strawberries/" + std::to_string(config.seed),
                   config.sets, [suite = suite_of(config.seed, config.sets)](const GridJob& job) {
                     return to_json(run_fruit_job(suite, job));
                   });
}

std::vector<ScoreRow> strawberries_pooled_rows(const ScoreFile& jobs, std::uint64_t seed) {
  return fruit_pooled_rows(suite_of(seed, {}), jobs);
}

void add_strawberries_plots(SeedsReport& report) {
  const std::vector<ScoreRow>& rows = report.scores.scores;
  if (std::none_of(rows.begin(), rows.end(),
                   [](const ScoreRow& row) { return row.suite == "strawberries"; }))
    return;
  for (LinePlot plot :
       {abstention_plot(rows, "ours", "volume", "volume.mape", "Mean error of the volume, %", 100),
        abstention_plot(rows, "ours", "volume", "cut.error_3d", "Median error of the cut point, mm",
                        1e3)}) {
    if (!plot.series.empty()) report.lines.push_back(std::move(plot));
  }
  std::vector<std::string> names;
  for (const Level& camera : cameras()) names.push_back(camera.word);
  report.tables.push_back(camera_table(rows, "ours", names,
                                       {{"measured, %", "volume.measured", 100, 0},
                                        {"centre, RMSE mm", "centre.rmse_3d", 1e3, 1},
                                        {"diameter, MAPE %", "diameter.mape", 100, 1},
                                        {"volume, MAPE %", "volume.mape", 100, 1},
                                        {"cut, median mm", "cut.error_3d", 1e3, 1},
                                        {"cut within 5 mm, % of all", "cut.within_5_mm", 100, 0},
                                        {"10 fruits, ms", "seconds.10_fruits", 1e3, 0}}));
}

}  // namespace cousin
