// run: from a scene to numbers and a report.
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include "benchmarks/app/commands.h"
#include "benchmarks/app/option_keys.h"
#include "benchmarks/app/pipeline_options.h"
#include "benchmarks/app/result_output.h"
#include "benchmarks/app/run_folder.h"
#include "benchmarks/loop/attribution.h"
#include "benchmarks/loop/keypoint_noise.h"
#include "benchmarks/loop/pipeline_run.h"
#include "benchmarks/loop/plan.h"
#include "benchmarks/loop/result_folder.h"
#include "benchmarks/loop/scene_table.h"
#include "benchmarks/loop/score_seeds.h"
#include "benchmarks/loop/seeds_report.h"
#include "benchmarks/loop/simulate.h"
#include "benchmarks/loop/specimens_text.h"
#include "benchmarks/study/shard.h"
#include "perception/sfm/colmap_run.h"
#include "perception/sfm/sfm_poses.h"
#include "sim/dataset/atomic_file.h"
#include "sim/dataset/categories.h"
#include "sim/dataset/manifest.h"
#include "sim/types/rng.h"
#include "sim/types/stage_clock.h"
#include "sim/types/whole_file.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

/// All that a run goes by.
struct RunJob {
  const SceneEntry& entry;
  const PipelineRow& row;
  RunConfig config;
  std::vector<StageSource> sources;
  std::shared_ptr<const LearnedDistance> learned;
  TruthNeeds truth;
  fs::path out;
  std::string key;  ///< of all that decides a scene's result, but its number

  const PipelineConfig& pipeline() const { return *config.pipeline; }
};

/// Options that stand for keys of the scene and its pipeline.
std::vector<KeyOption> run_keys(const Options& o) {
  std::vector<KeyOption> keys;
  if (o.frames > 0) keys.push_back({"--frames", "views", std::to_string(o.frames)});
  if (!o.method.empty()) keys.push_back({"--method", "pipeline.method", o.method});
  return keys;
}

// ---- What a run is configured by
// -----------------------------------------------------------------

/// The pipeline that is named, or the scene's own; null where it has none.
const PipelineRow* row_of_run(const Options& o, const SceneEntry& entry) {
  if (o.pipeline.empty()) return pipeline_of_scene(entry.text.name);
  const PipelineRow& row = pipeline_row(o.pipeline);
  const auto& scenes = row.scenes;
  if (scenes.empty() || std::find(scenes.begin(), scenes.end(), entry.text.name) != scenes.end())
    return &row;
  throw std::invalid_argument("--pipeline \"" + o.pipeline + "\" is of scene " +
                              std::string(scenes.front()) + ", not of " + entry.name());
}

RunConfig configure(const Options& o, const SceneEntry& entry,
                    std::optional<PipelineConfig> pipeline) {
  const std::vector<KeyOption> keys = run_keys(o);
  return read_config(o, keys, [&] {
    if (pipeline && !o.pipeline_config.empty())
      read_toml(o.pipeline_config, fields(*pipeline), MissingKeys::keep_default);
    RunConfig config =
        run_config(built_row(entry), assignments_of(o, keys), o.config, std::move(pipeline));
    planned_streams(config);  // refuses what the rig has not before anything is touched
    return config;
  });
}

/// All that decides a scene's result, but its number.
std::string run_key(const Options& o, const RunJob& job) {
  std::string key = COUSIN_VERSION + config_hash(job.config, o.seed);
  for (const std::string& stage : o.stages) key += "\n" + stage;
  if (o.attribution) key += "\nattribution";
  if (o.align) key += "\nalign";
  if (!o.lpips.empty()) key += "\n" + sha256_hex_of_file(o.lpips);
  return key + user_folders_hash(job.pipeline());
}

RunJob run_job(const Options& o, const SceneEntry& entry, const PipelineRow& row) {
  const std::string name = pipeline_of_scene(entry.text.name) == &row
                               ? entry.name()
                               : entry.name() + "_" + std::string(row.name);
  RunJob job{.entry = entry,
             .row = row,
             .config = configure(o, entry, row.defaults()),
             .sources = stage_sources(o, row),
             .learned = learned_of(o),
             .truth = {},
             .out = o.out.empty() ? fs::path("out") / name : fs::path(o.out),
             .key = {}};
  job.truth = planned_truth(job.pipeline(), o.attribution);
  if (!o.keys && !o.plan) job.key = run_key(o, job);
  return job;
}

std::vector<PlanEntry> plan_of(const Options& o, const RunJob& job) {
  return run_plan(job.config, o.attribution, job.sources);
}

/// What the capture says of its frames before any is rendered.
Capture outline_of(const Simulation& built) {
  Capture capture = built.capture_header();
  for (const TrueView& view : built.views())
    capture.frames.push_back(built.rig().outline(view.frame, {.color = true}));
  return capture;
}

/// Whether poses are found by COLMAP. The scene is built only where that depends on its rig.
bool asks_sfm(const Options& o, const RunJob& job) {
  if (replaces(job.sources, "poses") || !needs_sfm(Capture{}, job.pipeline())) return false;
  return needs_sfm(outline_of(Simulation(job.config, o.seed, 0)), job.pipeline());
}

// ---- One scene
// -----------------------------------------------------------------------------------

SeedsScoreLabels run_labels(const RunJob& job, std::uint64_t seed) {
  SeedsScoreLabels labels;
  labels.seed = seed;
  labels.suite = "run";
  labels.method = std::string(method_of(job.pipeline()));
  labels.settings.views = job.config.scene.views();
  return labels;
}

ScoreRow simulator_row(const SeedsScoreLabels& labels, const std::string& metric, double value_s) {
  ScoreRow row = labelled_row(labels);
  row.method = "simulator";
  row.metric = metric;
  row.value = value_s;
  row.unit = "s";
  row.n = 1;
  return row;
}

ScoreRow with_timing(ScoreRow row, const StageTiming& timing) {
  row.wall_s = timing.wall_s;
  row.cpu_s = timing.cpu_s;
  row.peak_rss_mb = timing.peak_rss_mb;
  row.peak_above_start_mb = timing.peak_above_start_mb;
  return row;
}

/// Seconds of the simulator's passes as rows.
std::vector<ScoreRow> timing_rows(const SimulatedRun& run, const SeedsScoreLabels& labels) {
  std::vector<ScoreRow> rows;
  const auto add = [&](const std::string& metric, const StageTiming& timing) {
    rows.push_back(with_timing(simulator_row(labels, metric, timing.wall_s), timing));
  };
  for (const StageTiming& timing : run.timings) add("seconds." + timing.stage, timing);
  // A part of seconds.render, under a name that no sum of stages takes up.
  if (run.radiance.wall_s > 0) add("seconds_of_render." + run.radiance.stage, run.radiance);
  return rows;
}

TruthNeeds without(const TruthNeeds& planned) {
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
  return others;
}

/// What leaving passes out saved: one view is measured, all views are counted. Light that is not
/// traced is not traced here either: `bench render` measures it.
std::vector<ScoreRow> left_out_rows(const RunJob& job, std::uint64_t seed,
                                    const SeedsScoreLabels& labels) {
  const Simulation built(job.config, seed, 0);
  std::vector<ScoreRow> rows;
  const auto measure = [&](const std::string& what, const auto& pass) {
    const StageClock clock("left out");
    pass();
    ScoreRow row = simulator_row(labels, "seconds_saved." + what + "_left_out",
                                 clock.finish().wall_s * job.config.scene.views());
    row.n = job.config.scene.views();
    rows.push_back(std::move(row));
  };
  measure("truth_passes", [&] { built.truth(0, without(job.truth)); });
  const Streams there_are = streams_of(job.config.rig), taken = planned_streams(job.config);
  const Streams left{.infrared = there_are.infrared && !taken.infrared,
                     .depth = there_are.depth && !taken.depth};
  const bool matched = taken.depth && job.config.capture.depth_by == DepthBy::matched;
  if (left.depth || (left.infrared && !matched))  // what is matched was rendered anyway
    measure("infrared_and_depth", [&] { built.take(0, left); });
  return rows;
}

/// True seams for the stages that the pipeline has not.
Stages stages_from_truth(const RunJob& job, const SimulatedRun& run, int scene) {
  Rng rng = Rng(run.truth.seed).fork("keypoints").fork(static_cast<std::uint64_t>(scene));
  return outside_stages(run, job.row, job.config.keypoints, rng(), job.config.boxes);
}

/// One scene of a run: rows and specimens. The first scene's pictures go into `report`.
ScoreFile run_scene(const JobContext& context, const RunJob& job, int scene, SeedsReport& report) {
  const Options& o = context.options;
  const auto progress = context.progress.function();
  SeedsScoreLabels labels = run_labels(job, o.seed);
  labels.scene = labels.run = scene_id(scene);
  const fs::path estimate_dir = job.out / "estimate" / scene_id(scene);
  const SimulatedRun run = simulate(job.config, o.seed, scene, job.truth, progress);
  PipelineConfig written = job.pipeline();
  write_file(estimate_dir / "config.toml", to_toml(fields(written)));
  const PerceivedScene made = perceive_scene(
      {.capture = run.capture,
       .config = job.pipeline(),
       .seed = o.seed,
       .sources = job.sources,
       .scene_index = scene,
       .name = labels.scene,
       .estimate_dir = estimate_dir,
       .learned = job.learned.get(),
       .outside = stages_from_truth(job, run, scene)},
      progress, [&](const std::string& text) { context.progress.line("warning: " + text); });
  context.progress.line(labels.scene + ": " + made.summary);
  for (const std::string& text : made.unmeasured) context.progress.line(text);
  // Without traits no row could say that nothing was solved.
  if (job.row.traits.empty() && !made.nothing.empty())
    throw std::runtime_error(labels.scene + ": " + made.nothing);
  ScoreFile file = score_scene(run, made, job.pipeline(),
                               o.align ? PoseAlignment::similarity : PoseAlignment::none, labels);
  append({.scores = timing_rows(run, labels)}, file);
  if (o.attribution) {
    const Stages own =
        with_outside(stages_of(job.pipeline(), run.capture, o.seed, job.sources, scene),
                     stages_from_truth(job, run, scene), job.row);
    const auto steps = attribute(run, job.pipeline(), own, labels, &made.estimate, progress);
    append({.scores = attribution_rows(steps, job.row.traits, labels)}, file);
  }
  if (scene == 0) {
    report.scenes = {page_scene(labels.scene, run, made, job.pipeline(), estimate_dir)};
    append({.scores = left_out_rows(job, o.seed, labels)}, file);
  }
  return file;
}

// ---- All scenes
// ----------------------------------------------------------------------------------

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
bool run_scenes(const JobContext& context, const RunJob& job, const fs::path& parts,
                SeedsReport& report) {
  const Options& o = context.options;
  std::vector<ShardJob> jobs;
  for (int scene = 1; scene < o.scenes; ++scene) {
    const std::string name = part_file(parts, scene).filename();
    jobs.push_back({name, job.key + "\n" + scene_id(scene),
                    [&, scene] { return to_json(run_scene(context, job, scene, report)); }});
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
  append(run_scene(context, job, 0, report), report.scores);
  for (const ShardResult& result : results) {
    append(scores_from_json(result.text, result.name), report.scores);
  }
  return resumed;
}

SeedsReport begin_report(const JobContext& context, const RunJob& job, bool by_colmap) {
  SeedsReport report;
  report.title = "Cousin: " + job.entry.name();
  if (pipeline_of_scene(job.entry.text.name) != &job.row)
    report.title += ", pipeline " + std::string(job.row.name);
  report.summary = page_summary(job.pipeline());
  report.command_line = context.command_line;
  report.config_toml = resolved_toml(job.config);
  report.plan = describe(plan_of(context.options, job));
  ScoreHeader& header = report.scores.header;
  header.program_version = COUSIN_VERSION;
  header.config_hash = config_hash(job.config, context.options.seed);
  header.machine = machine_text();
  header.more["command"] = context.command_line;
  header.more["title"] = report.title;
  header.more["summary"] = report.summary;
  if (by_colmap) header.more["colmap"] = colmap_version();
  return report;
}

ScoreRow whole_row(const JobContext& context, const RunJob& job, const StageTiming& whole) {
  SeedsScoreLabels labels = run_labels(job, context.options.seed);
  labels.scene = "pooled";
  ScoreRow row = simulator_row(labels, "seconds.run", whole.wall_s);
  row.method = "whole";
  row.n = context.options.scenes;
  return with_timing(std::move(row), whole);
}

/// The folder of a finished run; what is of this run alone goes.
void write_run(const RunJob& job, const SeedsReport& report, int scenes) {
  for (const ReportScene& scene : report.scenes)
    write_report_scene(report_scenes_folder(job.out), scene);
  write_report_folder(job.out, report);
  const fs::path parts = job.out / "parts";
  for (int scene = 1; scene < scenes; ++scene) remove_own(part_file(parts, scene));
  std::error_code not_empty;  // then it holds what this run has not written
  fs::remove(parts, not_empty);
}

ExitCode run_whole(const JobContext& context, const RunJob& job) {
  const Options& o = context.options;
  const StageClock total("run");
  for (const std::string& gate : o.gates) parse_gate(gate);
  require_writable(job.out);
  check_run_folder(job.out, job.key, o.scenes);
  const bool by_colmap = asks_sfm(o, job);
  if (by_colmap) require_sfm();
  for (const std::string& warning : user_mesh_warnings(job.config))
    context.progress.line("warning: " + warning);
  OutputFolder folder = run_folder(job.out, job.key, o.scenes);
  if (const auto names = specimen_categories(job.config.scene); !names.empty())
    write_categories(job.out / "estimate", names);
  SeedsReport report = begin_report(context, job, by_colmap);
  ScoreFile& file = report.scores;
  const bool resumed = run_scenes(context, job, job.out / "parts", report);
  SeedsScoreLabels labels = run_labels(job, o.seed);
  labels.scene = "pooled";
  append({.scores = pooled_rows(file.specimens, labels)}, file);
  const std::string unmeasured = unmeasured_sentence(file.specimens);
  if (!unmeasured.empty()) {
    report.summary += " " + unmeasured;
    file.header.more["summary"] = report.summary;
  }
  const StageTiming whole = total.finish();
  // Else these are not the whole run's seconds.
  if (!resumed) file.scores.push_back(whole_row(context, job, whole));
  write_run(job, report, o.scenes);
  folder.remove_other_configs();
  print_result(o, file);
  if (!unmeasured.empty()) context.progress.line(unmeasured);
  char line[160];
  std::snprintf(line, sizeof line, "%.1f s, peak %.0f MB; report: %s", whole.wall_s,
                whole.peak_rss_mb, (job.out / "report.html").string().c_str());
  context.progress.line(line);
  return check_gates(o, file.scores);
}

/// Pipelines that take any scene's photographs, as a sentence.
std::string pipelines_of_anything(const std::string& scene) {
  std::string text;
  for (const PipelineRow* each : pipeline_table()) {
    const PipelineRow& row = *each;
    if (!row.scenes.empty()) continue;
    text += "`cousin run " + scene + " --pipeline " + std::string(row.name) +
            "`: " + std::string(row.help) + "; ";
  }
  return text + "`cousin render " + scene + "` writes its images and truth";
}

/// Of a scene that can be rendered only: its keys and its plan.
ExitCode run_without_pipeline(const JobContext& context, const SceneEntry& entry) {
  const Options& o = context.options;
  const std::string none = "scene \"" + entry.name() + "\" has no pipeline of its own yet; " +
                           pipelines_of_anything(entry.name());
  refuse_given(o, {"--method", "--stage", "--attribution", "--gate", "--pipeline-config"},
               "is not read: " + none);
  refuse_whole_scene_options(o);
  const RunConfig config = configure(o, entry, std::nullopt);
  if (o.keys) {
    std::printf("%s", keys_text(config).c_str());
  } else if (o.plan) {
    std::vector<PlanEntry> plan = simulator_plan(config);
    plan.push_back({"perceive", false, "there is no pipeline for this scene yet"});
    plan.push_back({"score", false, "there is no estimate"});
    print_plan(o, plan);
  } else {
    throw std::invalid_argument(none);
  }
  return ExitCode::done;
}

}  // namespace

ExitCode command_run(const JobContext& context) {
  const Options& o = context.options;
  const SceneEntry& entry = scene_entry(o.arguments.at(0));
  const PipelineRow* row = row_of_run(o, entry);
  if (!row) return run_without_pipeline(context, entry);
  refuse_foreign_options(o, *row);
  const RunJob job = run_job(o, entry, *row);
  if (o.keys) {
    std::printf("%s", keys_text(job.config).c_str());
    return ExitCode::done;
  }
  if (o.plan) {
    print_plan(o, plan_of(o, job));
    return ExitCode::done;
  }
  return run_whole(context, job);
}

}  // namespace cousin
