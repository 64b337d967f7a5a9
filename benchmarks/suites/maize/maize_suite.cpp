#include "benchmarks/suites/maize/maize_suite.h"

#include <algorithm>
#include <stdexcept>

#include "benchmarks/loop/keypoint_noise.h"
#include "benchmarks/loop/perceive.h"
#include "benchmarks/loop/score_plants.h"
#include "benchmarks/study/shard_scores.h"
#include "perception/pipelines/maize.h"
#include "scenes/maize/maize_scene.h"
#include "sim/types/rng.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

constexpr const char* kMaizeSuite = "maize";
constexpr int kCaptures = 4, kDraws = 6, kQuickDraws = 4;

/// A method of the suite: a row of the pipeline with keys.
struct SuiteMethod {
  const char* name;
  std::vector<std::string> sets;
};
const std::vector<SuiteMethod>& suite_methods() {
  static const std::vector<SuiteMethod> kMethods = {{"paper", {"method=paper"}},
                                                    {"triangulation", {"method=triangulation"}},
                                                    {"stem", {"method=ours", "match_images=false"}},
                                                    {"ours", {"method=ours"}}};
  return kMethods;
}

/// The plants of the ordinary captures: growth stage, and how far the camera is.
Factor stage_factor() {
  // Nearer, the taller ones are not whole in the frame.
  return {"stage",
          {{"V6", {"stage=V6", "distance_min_m=0.65", "distance_max_m=0.85"}},
           {"V7", {"stage=V7", "distance_min_m=0.85", "distance_max_m=1.05"}},
           {"V8", {"stage=V8", "distance_min_m=1.05", "distance_max_m=1.2"}}}};
}
std::vector<Factor> common_factors(const char* views) {
  return {key_factor("views", {views}),         key_factor("pitch_min_rad", {"-0.05"}),
          key_factor("pitch_max_rad", {"0.2"}), key_factor("height_min", {"0.48"}),
          key_factor("height_max", {"0.52"}),   key_factor("render.pixel_samples", {"6"})};
}
std::vector<Factor> joined(std::vector<Factor> first, const std::vector<Factor>& more) {
  first.insert(first.end(), more.begin(), more.end());
  return first;
}

/// The special captures: each with the keys that make it so.
Factor special_factor() {
  const std::vector<std::string> v7 = {"stage=V7", "distance_min_m=0.85", "distance_max_m=1.05"};
  const auto with = [&](std::vector<std::string> sets) {
    sets.insert(sets.begin(), v7.begin(), v7.end());
    return sets;
  };
  return {"special",
          {{"exact_calibration",
            with({"rig.rgb.lens.report_centre_error_px_per_width=0",
                  "rig.rgb_right.lens.report_centre_error_px_per_width=0",
                  "rig.rgb.lens.report_focal_error=0", "rig.rgb_right.lens.report_focal_error=0",
                  "rig.rgb.lens.report_distortion_error=0",
                  "rig.rgb_right.lens.report_distortion_error=0"})},
           {"row", with({"plants=5", "azimuth_spread_rad=0.5"})},
           {"wind", with({"wind=3"})},
           {"wind_apart", with({"wind=3", "rig.rgb_right.trigger_delay_s=0.03"})}}};
}

Grid maize_grid(const MaizeSuiteConfig& config) {
  if (config.quick) return {{"quick_{stage}", joined({stage_factor()}, common_factors("1"))}};
  const int captures = config.runs > 0 ? config.runs : kCaptures;
  return {{"{stage}_run{run}",
           joined({number_factor("run", 0, captures), stage_factor()}, common_factors("2"))},
          {"{special}_run{run}",
           joined({number_factor("run", 0, std::max(1, captures / 2)), special_factor()},
                  common_factors("2"))}};
}

KeypointNoiseConfig noise_of(const NodeErrorCase& node_case) {
  KeypointNoiseConfig noise;
  for (const std::string& set : node_case.sets) set_field(fields(noise), set);
  validate(noise);
  return noise;
}

/// Everything that one capture's pieces share.
struct CaptureJob {
  const MaizeSuiteConfig& suite;
  const SimulatedRun& simulated;
  std::string scene, run;
  int number = 0;
};

/// One draw of one case by one method.
void add_draw(const CaptureJob& job, const NodeErrorCase& node_case, int draw,
              const SuiteMethod& method, ScoreFile& file) {
  MaizePipelineConfig maize;
  for (const std::string& set : method.sets) set_field(fields(maize), set);
  // All of a node's error in common is known to who knows the detector.
  const KeypointNoiseConfig noise = noise_of(node_case);
  if (noise.common_sigma_px > 0 && noise.sigma_px == 0) maize.stem.common_share = 0.99;
  maize.measure_height = node_case.has_height && draw == 0;
  const PipelineConfig config(maize);
  Rng rng = Rng(job.suite.seed)
                .fork(node_case.name)
                .fork(static_cast<std::uint64_t>(job.number))
                .fork(static_cast<std::uint64_t>(draw));
  const StageClock clock("perceive");
  const Estimate estimate =
      perceive(job.simulated.capture, config, job.suite.seed, {}, 0, {}, {}, {},
               outside_stages(job.simulated, row_of(config), noise, rng()));
  const double wall_s = clock.finish().wall_s;
  SeedsScoreLabels labels;
  labels.suite = node_case.name;
  labels.scene = job.scene;
  labels.run = job.run;
  labels.method = method.name;
  labels.seed = job.suite.seed;
  SeedsScores scores = score_plants(job.simulated.truth, estimate, labels);
  for (SpecimenRow& row : scores.specimens) {
    if (row.trait == "plant_height" && !maize.measure_height) continue;
    row.instance += 100000 * draw;
    file.specimens.push_back(std::move(row));
  }
  for (ScoreRow& row : scores.rows) {
    const bool is_count = row.metric.starts_with("nodes.") || row.metric.starts_with("plants.") ||
                          row.metric.starts_with("internodes.");
    if (draw > 0 || !is_count) continue;
    row.suite = kMaizeSuite;
    row.case_name = node_case.name + " " + job.run;
    file.scores.push_back(std::move(row));
  }
  if (draw > 0) return;
  ScoreRow seconds =
      seconds_row(labels, wall_s, static_cast<std::int64_t>(job.simulated.capture.frames.size()));
  seconds.suite = kMaizeSuite;
  seconds.case_name = node_case.name + " " + job.run;
  file.scores.push_back(std::move(seconds));
}

ScoreFile run_capture(const MaizeSuiteConfig& suite, const GridJob& job) {
  std::vector<std::string> sets = job.sets;
  sets.insert(sets.end(), suite.sets.begin(), suite.sets.end());
  const RunConfig config = run_config(maize_row(), sets, {}, PipelineConfig(MaizePipelineConfig{}));
  TruthNeeds needs;
  needs.depth = needs.instance = needs.keypoints = true;
  const int run = job.has("run") ? job.number("run") : 0;
  // Stages of one run are other plants.
  const bool is_special = job.has("special");
  const int number = 10 * run + static_cast<int>(is_special ? 3 : job.at("stage").level);
  const SimulatedRun simulated = simulate(config, suite.seed, number, needs, {});
  const std::string name = is_special ? job.at("special").word : job.at("stage").word;
  const CaptureJob capture{suite, simulated, is_special ? name : "plants",
                           name + "_run" + std::to_string(run), number};
  ScoreFile file;
  for (const NodeErrorCase& node_case : node_error_cases()) {
    const bool is_asked = !is_special || node_case.name == "truth" || node_case.name == "own_1px";
    const int draws = node_case.name == "truth" ? 1 : suite.quick ? kQuickDraws : kDraws;
    for (int draw = 0; is_asked && draw < draws; ++draw) {
      for (const SuiteMethod& method : suite_methods())
        add_draw(capture, node_case, draw, method, file);
    }
  }
  return file;
}

}  // namespace

const std::vector<NodeErrorCase>& node_error_cases() {
  // A mean error of 6 px [Maize, Table 1] is a deviation of 6 / sqrt(pi / 2) px each axis.
  static const std::vector<NodeErrorCase> kCases = {
      {"truth", {}, true},
      {"own_1px", {"sigma_px=1"}, true},
      {"both_1px", {"common_sigma_px=1"}},
      {"own_6px", {"sigma_px=4.79"}},
      {"both_6px", {"common_sigma_px=4.79"}},
      {"gross", {"sigma_px=1", "gross_share=0.12", "gross_sigma_px=32.6"}},
      {"detector",
       {"sigma_px=1", "gross_share=0.12", "gross_sigma_px=32.6", "missed=0.11",
        "false_points=0.4"}}};
  return kCases;
}

std::vector<ShardJob> maize_suite_jobs(const MaizeSuiteConfig& config) {
  return shards_of(
      maize_grid(config), std::string(COUSIN_VERSION) + "/maize/" + std::to_string(config.seed),
      config.sets, [config](const GridJob& job) { return to_json(run_capture(config, job)); });
}

}  // namespace cousin
