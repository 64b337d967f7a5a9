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
#include "benchmarks/app/result_output.h"
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
#include "sim/dataset/atomic_file.h"
#include "sim/dataset/capture_io.h"
#include "sim/dataset/manifest.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

constexpr const char* kPipeline = "pipeline.";

/// What the command line configures.
struct RunConfig {
  SceneJob scene;
  ViewsPipelineConfig views;
  std::vector<StageSource> sources;
};

RunConfig run_config(const Options& o, const SceneEntry& entry) {
  std::vector<std::string> of_scene, of_pipeline;
  for (const std::string& set : o.sets) {
    const std::string prefix = kPipeline;
    const bool is_pipelines = set.starts_with(prefix);
    (is_pipelines ? of_pipeline : of_scene)
        .push_back(is_pipelines ? set.substr(prefix.size()) : set);
  }
  if (o.frames > 0) of_scene.push_back("views=" + std::to_string(o.frames));
  return {entry.configure(of_scene, o.config), views_config({}, o.method, of_pipeline),
          views_sources(o.stages)};
}

std::string pipeline_toml(const RunConfig& config) {
  ViewsPipelineConfig copy = config.views;
  return to_toml(fields(copy));
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
  const ViewsRun run =
      perceive_views(capture, config.views, o.seed, config.sources, scene, scene_id(scene),
                     out / "estimate" / scene_id(scene), context.progress.function(),
                     [&](const std::string& text) { context.progress.line("warning: " + text); });
  context.progress.line(scene_id(scene) + ": " + views_summary(run, capture.frames.size()));
  ScoreRow base;
  base.suite = "run";
  base.scene = scene_id(scene);
  base.case_name = "photographs";
  base.method = to_string(config.views.method);
  base.seed = o.seed;
  std::vector<ScoreRow> rows =
      score_views(built.scene_truth(), run.estimate,
                  o.align ? PoseAlignment::similarity : PoseAlignment::none, true, base);
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

std::string plan_text(const RunConfig& config) {
  return describe(config.scene.plan()) +
         "\nPipeline views: poses, splats, depth, cloud, surfaces\n";
}

}  // namespace

ExitCode command_run_views(const JobContext& context) {
  const Options& o = context.options;
  const SceneEntry& entry = scene_entry(o.arguments.at(0));
  if (o.attribution)
    throw std::invalid_argument("--attribution is of the pipeline seeds, not of views");
  const RunConfig config = run_config(o, entry);
  if (o.keys) return print_keys(config);
  if (o.plan) {
    std::printf("%s", plan_text(config).c_str());
    return ExitCode::done;
  }
  for (const std::string& gate : o.gates) parse_gate(gate);
  const fs::path out = o.out.empty() ? fs::path("out") / (entry.name + "_views") : fs::path(o.out);
  require_writable(out);

  SeedsReport report;
  report.title = "Cousin: " + entry.name + ", Gaussians of photographs";
  report.summary =
      "Photographs by a virtual camera became Gaussians, and from these depth, a cloud and a mesh. "
      "Images are scored against photographs, held-out ones among them, shapes against every true "
      "surface that two views at least could see, and near specimens.";
  report.command_line = context.command_line;
  report.config_toml = pipeline_toml(config);
  report.plan = plan_text(config);
  ScoreFile& file = report.scores;
  file.header.program_version = COUSIN_VERSION;
  file.header.config_hash = sha256_hex(config.scene.hash(o.seed) + report.config_toml);
  file.header.machine = machine_text();
  file.header.more["colmap"] = colmap_version();
  file.header.more["command"] = context.command_line;
  file.header.more["title"] = report.title;
  file.header.more["summary"] = report.summary;

  std::string key = COUSIN_VERSION + file.header.config_hash + std::to_string(o.seed);
  for (const std::string& stage : o.stages) key += "\n" + stage;
  if (o.align) key += "\nalign";
  std::vector<ShardJob> jobs;
  for (int scene = 0; scene < o.scenes; ++scene) {
    jobs.push_back({scene_id(scene) + ".json", key + "\n" + scene_id(scene), [&, scene] {
                      return to_json(
                          ScoreFile{.scores = rows_of_scene(context, config, scene, out)});
                    }});
  }
  const fs::path parts = out / "parts";
  for (const ShardResult& result : run_shards(parts, jobs, {})) {
    if (result.failure) std::rethrow_exception(result.failure);
    append(scores_from_json(result.text, result.name), file);
  }
  const BuiltScene first = config.scene.build(o.seed, 0);
  report.scenes = {views_report_scene(out / "estimate" / scene_id(0), first.scene_truth())};
  write_report_scene(report_scenes_folder(out), report.scenes.front());
  write_report_folder(out, report);
  for (const ShardJob& job : jobs) fs::remove(parts / job.name);
  std::error_code not_empty;
  fs::remove(parts, not_empty);
  print_result(o, file);
  context.progress.line("report: " + (out / "report.html").string());
  return check_gates(o, file.scores);
}

}  // namespace cousin
