// run --pipeline views: from any scene to Gaussians, numbers and a report.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks/app/commands.h"
#include "benchmarks/app/option_keys.h"
#include "benchmarks/app/result_output.h"
#include "benchmarks/app/run_folder.h"
#include "benchmarks/app/views_options.h"
#include "benchmarks/scenes/scene_table.h"
#include "benchmarks/seeds/report_scene.h"
#include "benchmarks/seeds/result_folder.h"
#include "benchmarks/seeds/score_seeds.h"
#include "benchmarks/seeds/seeds_report.h"
#include "benchmarks/shards/shard.h"
#include "benchmarks/views/score_views.h"
#include "benchmarks/views/views_report.h"
#include "perception/sfm/colmap_run.h"
#include "perception/sfm/sfm_poses.h"
#include "sim/dataset/atomic_file.h"
#include "sim/dataset/capture_io.h"
#include "sim/dataset/manifest.h"
#include "sim/types/stage_clock.h"
#include "sim/types/whole_file.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

constexpr const char* kPipeline = "pipeline.";

/// What the command line configures.
struct RunConfig {
  SceneJob scene;
  ViewsPipelineConfig views;
  std::vector<StageSource> sources;
  std::shared_ptr<const LearnedDistance> learned;
};

RunConfig run_config(const Options& o, const SceneEntry& entry) {
  std::vector<std::string> of_scene, of_pipeline;
  for (const std::string& set : o.sets) {
    const std::string prefix = kPipeline;
    const bool is_pipelines = set.starts_with(prefix);
    (is_pipelines ? of_pipeline : of_scene)
        .push_back(is_pipelines ? set.substr(prefix.size()) : set);
  }
  std::vector<KeyOption> keys;
  if (o.frames > 0) keys.push_back({"--frames", "views", std::to_string(o.frames)});
  for (const KeyOption& each : keys) of_scene.push_back(each.assignment());
  return {read_config(o, keys, [&] { return entry.configure(of_scene, o.config); }),
          views_config(o, o.pipeline_config, of_pipeline), views_sources(o), learned_of(o)};
}

/// As `cousin perceive` writes it beside its estimate.
std::string pipeline_toml(const RunConfig& config) {
  ViewsPipelineConfig copy = config.views;
  return to_toml(fields(copy));
}

/// What the capture says of its frames before any is rendered.
Capture outline_of(const BuiltScene& built) {
  Capture capture = built.capture_header();
  for (const TrueView& view : *built.views)
    capture.frames.push_back(built.rig->outline(view.frame, {.color = true}));
  return capture;
}

/// Photographs of a built scene as the rig hands them over, without its other streams.
Capture photographs_of(const BuiltScene& built, const Progress& progress) {
  Capture capture = built.capture_header();
  const int frames = static_cast<int>(built.views->size());
  for (int i = 0; i < frames; ++i) {
    progress("render", i, frames);
    capture.frames.push_back(built.take(i, {.color = true}).frame);
  }
  return capture;
}

std::vector<ScoreRow> rows_of_scene(const JobContext& context, const RunConfig& config, int scene,
                                    const fs::path& out) {
  const Options& o = context.options;
  const BuiltScene built = config.scene.build(o.seed, scene);
  const StageClock clock("render");
  const Capture capture = photographs_of(built, context.progress.function());
  const StageTiming rendered = clock.finish();
  write_file(out / "estimate" / scene_id(scene) / "config.toml", pipeline_toml(config));
  const ViewsRun run = perceive_views(
      capture, config.views, o.seed, config.sources, scene, scene_id(scene),
      out / "estimate" / scene_id(scene), context.progress.function(),
      [&](const std::string& text) { context.progress.line("warning: " + text); },
      config.learned.get());
  context.progress.line(scene_id(scene) + ": " + views_summary(run, capture.frames.size()));
  if (run.estimate.splats.splats.empty())
    throw std::runtime_error(scene_id(scene) + ": " + no_gaussians_text(run.estimate.splats));
  ScoreRow base;
  base.suite = "run";
  base.scene = scene_id(scene);
  base.case_name = "photographs";
  base.method = to_string(config.views.method);
  base.seed = o.seed;
  std::vector<ScoreRow> rows = score_views(
      built.scene_truth(), run.estimate, o.align ? PoseAlignment::similarity : PoseAlignment::none,
      fs::exists(out / "estimate" / scene_id(scene) / "cloud.ply"), base);
  // The pipeline's own rows have its seconds too.
  std::erase_if(rows, [](const ScoreRow& row) { return row.metric.starts_with("seconds."); });
  for (ScoreRow row : run.rows) {
    row.suite = base.suite;
    rows.push_back(std::move(row));
  }
  ScoreRow seconds = base;
  seconds.method = "simulator";
  seconds.metric = "seconds.render";
  seconds.unit = "s";
  seconds.n = 1;
  seconds.value = seconds.wall_s = rendered.wall_s;
  seconds.cpu_s = rendered.cpu_s;
  seconds.peak_rss_mb = rendered.peak_rss_mb;
  seconds.peak_above_start_mb = rendered.peak_above_start_mb;
  rows.push_back(std::move(seconds));
  return rows;
}

ExitCode print_keys(const RunConfig& config) {
  ViewsPipelineConfig copy = config.views;
  std::printf("%s\nof --pipeline views, each after \"%s\":\n%s", config.scene.keys.c_str(),
              kPipeline, describe(fields(copy)).c_str());
  return ExitCode::done;
}

/// The simulator's passes and the pipeline's stages.
std::vector<PlanEntry> plan_of(const RunConfig& config) {
  const ViewsPipelineConfig& views = config.views;
  const auto stage = [&](const char* name, bool is_ours, const std::string& why) {
    const bool is_read = replaces(config.sources, name);
    return PlanEntry{name, is_read || is_ours, is_read ? "--stage in place of ours" : why};
  };
  return {
      {"colour", true, std::to_string(config.scene.views) + " photographs a scene"},
      {"other streams, truth images", false,
       "the pipeline reads photographs, scores read the scene's shapes and cameras"},
      stage("poses", true, "the capture's where half of it has them, else by COLMAP"),
      stage("splats", true, std::string(to_string(views.method))),
      stage("depth", true, "of the Gaussians"),
      stage("cloud", views.cloud_views > 0, "cloud_views=" + std::to_string(views.cloud_views)),
      stage("surfaces", views.mesh_cells > 0, "mesh_cells=" + std::to_string(views.mesh_cells))};
}

}  // namespace

ExitCode command_run_views(const JobContext& context) {
  const Options& o = context.options;
  const SceneEntry& entry = scene_entry(o.arguments.at(0));
  refuse_given(o, {"--attribution"},
               "is of the pipeline seeds; `cousin run " + entry.name +
                   " --pipeline views` puts no truth in place of stages");
  const RunConfig config = run_config(o, entry);
  if (o.keys) return print_keys(config);
  if (o.plan) {
    print_plan(o, plan_of(config));
    return ExitCode::done;
  }
  for (const std::string& gate : o.gates) parse_gate(gate);
  const fs::path out = o.out.empty() ? fs::path("out") / (entry.name + "_views") : fs::path(o.out);
  require_writable(out);
  for (const std::string& warning : config.scene.warnings())
    context.progress.line("warning: " + warning);

  SeedsReport report;
  report.title = "Cousin: " + entry.name + ", Gaussians of photographs";
  report.summary =
      "Photographs by a virtual camera became Gaussians, and from these depth, a cloud and a mesh. "
      "Images are scored against photographs, held-out ones among them, shapes against every true "
      "surface that two views at least could see, and near specimens.";
  report.command_line = context.command_line;
  const std::string pipeline = pipeline_toml(config);
  report.plan = describe(plan_of(config)) + "\nThe pipeline's keys:\n" + pipeline;
  ScoreFile& file = report.scores;
  file.header.program_version = COUSIN_VERSION;
  file.header.config_hash = sha256_hex(config.scene.hash(o.seed) + pipeline);
  file.header.machine = machine_text();
  file.header.more["colmap"] = colmap_version();
  file.header.more["command"] = context.command_line;
  file.header.more["title"] = report.title;
  file.header.more["summary"] = report.summary;

  std::string key = COUSIN_VERSION + file.header.config_hash + std::to_string(o.seed);
  for (const std::string& stage : o.stages) key += "\n" + stage;
  if (o.align) key += "\nalign";
  if (!o.lpips.empty()) key += "\n" + sha256_hex_of_file(o.lpips);
  if (!config.views.masks.empty()) key += "\n" + sha256_hex_of_folder(config.views.masks);
  check_run_folder(out, key, o.scenes);
  const BuiltScene first = config.scene.build(o.seed, 0);
  if (needs_sfm(outline_of(first), config.views) && !replaces(config.sources, "poses"))
    require_sfm();
  const SceneTruth truth = first.scene_truth();
  report.config_toml = truth.config_toml;
  OutputFolder folder = run_folder(out, key, o.scenes);
  std::vector<ShardJob> jobs;
  for (int scene = 0; scene < o.scenes; ++scene) {
    jobs.push_back({scene_id(scene) + ".json", key + "\n" + scene_id(scene), [&, scene] {
                      return to_json(
                          ScoreFile{.scores = rows_of_scene(context, config, scene, out)});
                    }});
  }
  const fs::path parts = out / "parts";
  for (const ShardJob& job : jobs) {
    if (is_finished(parts, job))
      context.progress.line("taken from the run that was stopped: " + (parts / job.name).string());
  }
  StepClock clock;
  const auto say = [&](const std::string& name, int done, int scenes) {
    if (scenes > 1)
      context.progress.line("scene " + name.substr(0, 6) + ", " + std::to_string(done + 1) +
                            " of " + std::to_string(scenes) + clock.text(done, scenes));
  };
  for (const ShardResult& result : run_shards(parts, jobs, {}, say)) {
    if (result.failure) std::rethrow_exception(result.failure);
    append(scores_from_json(result.text, result.name), file);
  }
  report.scenes = {views_report_scene(out / "estimate" / scene_id(0), truth)};
  write_report_scene(report_scenes_folder(out), report.scenes.front());
  write_report_folder(out, report);
  for (const ShardJob& job : jobs) remove_own(parts / job.name);
  std::error_code not_empty;
  fs::remove(parts, not_empty);
  folder.remove_other_configs();
  print_result(o, file);
  context.progress.line("report: " + (out / "report.html").string());
  return check_gates(o, file.scores);
}

}  // namespace cousin
