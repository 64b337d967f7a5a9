// run: from a scene to numbers and a report.
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "benchmarks/app/commands.h"
#include "benchmarks/app/option_keys.h"
#include "benchmarks/app/result_output.h"
#include "benchmarks/app/run_folder.h"
#include "benchmarks/app/specimens_text.h"
#include "benchmarks/scenes/scene_table.h"
#include "benchmarks/seeds/attribution.h"
#include "benchmarks/seeds/perceive.h"
#include "benchmarks/seeds/plan.h"
#include "benchmarks/seeds/result_folder.h"
#include "benchmarks/seeds/score_seeds.h"
#include "benchmarks/seeds/seeds_report.h"
#include "benchmarks/seeds/splat_images.h"
#include "benchmarks/shards/shard.h"
#include "perception/sfm/sfm_poses.h"
#include "sim/dataset/capture_io.h"
#include "sim/types/stage_clock.h"
#include "sim/types/whole_file.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

/// Options that stand for keys of the scene and its own pipeline.
std::vector<KeyOption> run_keys(const Options& o) {
  std::vector<KeyOption> keys;
  if (o.frames > 0) keys.push_back({"--frames", "views", std::to_string(o.frames)});
  if (!o.method.empty()) keys.push_back({"--method", "pipeline.method", o.method});
  return keys;
}

/// Seconds of the simulator's passes as rows.
std::vector<ScoreRow> timing_rows(const SimulatedRun& run, const SeedsScoreLabels& labels) {
  std::vector<ScoreRow> rows;
  const auto add = [&](const std::string& metric, const StageTiming& timing) {
    ScoreRow row;
    row.suite = labels.suite;
    row.scene = labels.scene;
    row.case_name = labels.case_name;
    row.method = "simulator";
    row.metric = metric;
    row.value = timing.wall_s;
    row.unit = "s";
    row.n = 1;
    row.wall_s = timing.wall_s;
    row.cpu_s = timing.cpu_s;
    row.peak_rss_mb = timing.peak_rss_mb;
    row.peak_above_start_mb = timing.peak_above_start_mb;
    row.seed = labels.seed;
    rows.push_back(std::move(row));
  };
  for (const StageTiming& timing : run.timings) add("seconds." + timing.stage, timing);
  // A part of seconds.render, under a name that no sum of stages takes up.
  if (run.radiance.wall_s > 0) add("seconds_of_render." + run.radiance.stage, run.radiance);
  return rows;
}

SeedsScoreLabels run_labels(const SeedsRunConfig& config, std::uint64_t seed) {
  SeedsScoreLabels labels;
  labels.seed = seed;
  labels.suite = "run";
  labels.method = std::string(to_string(config.pipeline.method));
  return labels;
}

/// What leaving passes out saved: one view is measured, all views are counted. Light that is not
/// traced is not traced here either: `bench render` measures it.
std::vector<ScoreRow> left_out_rows(const SeedsRunConfig& config, std::uint64_t seed,
                                    const SeedsScoreLabels& labels, const TruthNeeds& planned) {
  const SeedsSimulation simulation(config, seed, 0);
  std::vector<ScoreRow> rows;
  const auto measure = [&](const std::string& what, const auto& pass) {
    const StageClock clock("left out");
    pass();
    ScoreRow row;
    row.suite = labels.suite;
    row.scene = labels.scene;
    row.case_name = labels.case_name;
    row.method = "simulator";
    row.metric = "seconds_saved." + what + "_left_out";
    row.value = clock.finish().wall_s * config.scene.views;
    row.unit = "s";
    row.n = config.scene.views;
    row.seed = labels.seed;
    rows.push_back(std::move(row));
  };
  TruthNeeds others;
  others.depth = !planned.depth;
  others.normal = !planned.normal;
  others.position = !planned.position;
  others.instance = !planned.instance;
  others.part = !planned.part;
  others.coverage = !planned.coverage;
  others.visibility = !planned.visibility;
  others.shares = !planned.shares;
  others.keypoints = !planned.keypoints;
  others.flow = !planned.flow;
  measure("truth_passes", [&] { simulation.truth(0, others); });
  const Streams left = left_out_streams(config);
  const bool matched = planned_streams(config).depth && config.capture.depth_by == DepthBy::matched;
  if (left.depth || (left.infrared && !matched)) {  // what is matched was rendered anyway
    measure("infrared_and_depth",
            [&] { simulation.take(0, {.infrared = left.infrared, .depth = left.depth}); });
  }
  return rows;
}

/// One scene of a run: rows and specimens. The first scene's pictures go into `report`.
ScoreFile run_scene(const JobContext& context, const SeedsRunConfig& config, int scene,
                    const std::vector<StageSource>& sources, const fs::path& out,
                    SeedsReport& report) {
  const Options& o = context.options;
  SeedsScoreLabels labels = run_labels(config, o.seed);
  labels.scene = labels.run = scene_id(scene);
  const SimulatedRun run = simulate_seeds(config, o.seed, scene, planned_truth(o.attribution),
                                          context.progress.function());
  const Estimate estimate =
      perceive_seeds(run.capture, config.pipeline, o.seed, sources, scene,
                     out / "estimate" / scene_id(scene), context.progress.function(),
                     [&](const std::string& text) { context.progress.line("warning: " + text); });
  context.progress.line(labels.scene + ": " + specimens_text(estimate.traits));
  for (const std::string& text : unmeasured_lines(estimate.traits)) context.progress.line(text);
  SeedsScores scores = score_run(run.truth, estimate, labels);
  ScoreFile file;
  file.scores = std::move(scores.rows);
  file.specimens = std::move(scores.specimens);
  // How Gaussians look beside all photographs; no rows of a method without them.
  constexpr std::size_t kAllViews = std::numeric_limits<std::size_t>::max();
  append({.scores =
              splat_image_rows(run.capture, estimate, config.pipeline, labels, nullptr, kAllViews)},
         file);
  for (ScoreRow& row : timing_rows(run, labels)) file.scores.push_back(std::move(row));
  if (o.attribution) {
    const auto steps =
        attribute_seeds(run, config.pipeline, stages_of(config.pipeline, o.seed, sources, scene),
                        labels, &estimate, context.progress.function());
    for (ScoreRow& row : attribution_rows(steps, labels)) file.scores.push_back(std::move(row));
  }
  if (scene == 0) {
    report.scenes = {report_scene(labels.scene, run, estimate)};
    for (ScoreRow& row : left_out_rows(config, o.seed, labels, planned_truth(o.attribution)))
      file.scores.push_back(std::move(row));
  }
  return file;
}

/// All that decides what a scene's result is, but its number.
std::string run_key(const Options& o, const SeedsRunConfig& config) {
  std::string key = COUSIN_VERSION + config_hash(config, o.seed);
  for (const std::string& stage : o.stages) key += "\n" + stage;
  if (o.attribution) key += "\nattribution";
  return key;
}

fs::path part_file(const fs::path& parts, int scene) { return parts / (scene_id(scene) + ".json"); }

/// Names what an earlier run has finished. @return whether there is any.
bool say_what_is_there(ProgressPrinter& progress, const fs::path& parts,
                       const std::vector<ShardJob>& jobs, int scenes) {
  int there = 0;
  for (const ShardJob& job : jobs) {
    if (!is_finished(parts, job)) continue;
    ++there;
    progress.line("taken from the run that was stopped: " + (parts / job.name).string());
  }
  if (there > 0)
    progress.line(std::to_string(there) + " of " + std::to_string(scenes) +
                  " scenes are there already");
  return there > 0;
}

/// All scenes in order. Rows of the scenes after the first are kept in `parts` until the run is
/// whole, so that a run that was stopped goes on. The first scene comes last: its pictures are in
/// memory only. @return whether an earlier run's parts were taken.
bool run_scenes(const JobContext& context, const SeedsRunConfig& config,
                const std::vector<StageSource>& sources, const fs::path& out, const fs::path& parts,
                SeedsReport& report) {
  const Options& o = context.options;
  const std::string key = run_key(o, config);
  std::vector<ShardJob> jobs;
  for (int scene = 1; scene < o.scenes; ++scene) {
    const std::string name = part_file(parts, scene).filename();
    jobs.push_back({name, key + "\n" + scene_id(scene), [&, scene] {
                      return to_json(run_scene(context, config, scene, sources, out, report));
                    }});
  }
  const bool resumed = say_what_is_there(context.progress, parts, jobs, o.scenes);
  StepClock clock;
  const std::vector<ShardResult> results =
      run_shards(parts, jobs, {}, [&](const std::string& name, int done, int) {
        context.progress.line("scene " + name.substr(0, 6) + ", " + std::to_string(done + 1) +
                              " of " + std::to_string(o.scenes) + clock.text(done, o.scenes));
      });
  for (const ShardResult& result : results) {
    if (result.failure) std::rethrow_exception(result.failure);
  }
  append(run_scene(context, config, 0, sources, out, report), report.scores);
  for (const ShardResult& result : results) {
    append(scores_from_json(result.text, result.name), report.scores);
  }
  return resumed;
}

/// Of a scene that can be rendered only: its keys and its plan.
ExitCode run_without_pipeline(const JobContext& context, const SceneEntry& entry) {
  const Options& o = context.options;
  const std::string others = "`cousin run " + entry.name +
                             " --pipeline views` trains Gaussians on its photographs (--method "
                             "splats or splats_paper), `cousin render " +
                             entry.name + "` writes its images and truth";
  const std::string none = "scene \"" + entry.name + "\" has no pipeline of its own yet";
  refuse_given(o, {"--method", "--stage", "--attribution", "--gate", "--pipeline"},
               "is not read: " + none + "; " + others);
  const std::vector<KeyOption> keys = run_keys(o);
  const SceneJob job =
      read_config(o, keys, [&] { return entry.configure(assignments_of(o, keys), o.config); });
  if (o.keys) {
    std::printf("%s", job.keys.c_str());
  } else if (o.plan) {
    std::vector<PlanEntry> plan = job.plan();
    plan.push_back({"perceive", false, "there is no pipeline for this scene yet"});
    plan.push_back({"score", false, "there is no estimate"});
    print_plan(o, plan);
  } else {
    throw std::invalid_argument(none + "; " + others);
  }
  return ExitCode::done;
}

}  // namespace

ExitCode command_run(const JobContext& context) {
  const Options& o = context.options;
  const SceneEntry& entry = scene_entry(o.arguments.at(0));
  if (o.pipeline == "views") return command_run_views(context);
  if (!o.pipeline.empty() && o.pipeline != "seeds")
    throw std::invalid_argument("--pipeline \"" + o.pipeline + "\" is not one of: seeds, views");
  refuse_given(o, {"--align"}, "is of --pipeline views: seeds are measured in metres");
  refuse_given(o, {"--lpips"},
               "is of --pipeline views; `cousin bench seeds` has it for the Gaussians of seeds");
  refuse_given(o, {"--pipeline-config"},
               "is of --pipeline views; of seeds --config has the pipeline's keys too");
  if (!entry.has_pipeline) return run_without_pipeline(context, entry);
  const StageClock total("run");
  const std::vector<KeyOption> keys = run_keys(o);
  const SeedsRunConfig config =
      read_config(o, keys, [&] { return seeds_run_config(assignments_of(o, keys), o.config); });
  if (o.keys) {
    SeedsRunConfig copy = config;
    std::printf("%s", describe(fields(copy)).c_str());
    return ExitCode::done;
  }
  for (const std::string& gate : o.gates) parse_gate(gate);
  std::vector<StageSource> sources;
  for (const std::string& stage : o.stages)
    sources.push_back(parse_stage_source(stage, o.stage_time_limit_s));
  check_stages(sources, seeds_stage_order(), "seeds");
  const std::vector<PlanEntry> plan = seeds_plan(config, o.attribution, sources);
  if (o.plan) {
    print_plan(o, plan);
    return ExitCode::done;
  }
  if (needs_sfm(config.pipeline) && !replaces(sources, "poses")) require_sfm();
  const fs::path out = o.out.empty() ? fs::path("out") / "seeds" : fs::path(o.out);
  require_writable(out);
  for (const std::string& warning : entry.configure(assignments_of(o, keys), o.config).warnings())
    context.progress.line("warning: " + warning);
  OutputFolder folder = run_folder(out, run_key(o, config), o.scenes);

  SeedsReport report;
  report.command_line = context.command_line;
  report.config_toml = resolved_toml(config);
  report.plan = describe(plan);
  ScoreFile& file = report.scores;
  file.header.program_version = COUSIN_VERSION;
  file.header.config_hash = config_hash(config, o.seed);
  file.header.machine = machine_text();
  file.header.more["command"] = context.command_line;
  file.header.more["title"] = report.title;
  file.header.more["summary"] = report.summary;
  const fs::path parts = out / "parts";
  const bool resumed = run_scenes(context, config, sources, out, parts, report);
  SeedsScoreLabels labels = run_labels(config, o.seed);
  labels.scene = "pooled";
  for (ScoreRow& row : pooled_rows(file.specimens, labels)) file.scores.push_back(std::move(row));
  const std::string unmeasured = unmeasured_sentence(file.specimens);
  if (!unmeasured.empty()) {
    report.summary += " " + unmeasured;
    file.header.more["summary"] = report.summary;
  }
  const StageTiming whole = total.finish();
  ScoreRow row;
  row.suite = labels.suite;
  row.scene = labels.scene;
  row.case_name = "run";
  row.method = "whole";
  row.metric = "seconds.run";
  row.value = row.wall_s = whole.wall_s;
  row.cpu_s = whole.cpu_s;
  row.peak_rss_mb = whole.peak_rss_mb;
  row.peak_above_start_mb = whole.peak_above_start_mb;
  row.unit = "s";
  row.n = o.scenes;
  row.seed = o.seed;
  if (!resumed) file.scores.push_back(row);  // else these are not the whole run's seconds

  for (const ReportScene& scene : report.scenes) {
    write_report_scene(report_scenes_folder(out), scene);
  }
  write_report_folder(out, report);
  for (int scene = 1; scene < o.scenes; ++scene) remove_own(part_file(parts, scene));
  std::error_code not_empty;  // then it holds what this run has not written
  fs::remove(parts, not_empty);
  folder.remove_other_configs();
  print_result(o, file);
  if (!unmeasured.empty()) context.progress.line(unmeasured);
  char line[160];
  std::snprintf(line, sizeof line, "%.1f s, peak %.0f MB; report: %s", whole.wall_s,
                whole.peak_rss_mb, (out / "report.html").string().c_str());
  context.progress.line(line);
  return check_gates(o, file.scores);
}

}  // namespace cousin
