// perceive --pipeline views: Gaussians of photographs of anything.
#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks/app/commands.h"
#include "benchmarks/app/perceive_places.h"
#include "benchmarks/app/result_output.h"
#include "benchmarks/views/perceive_views.h"
#include "sim/dataset/atomic_file.h"
#include "sim/dataset/capture_io.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

ViewsPipelineConfig config_of(const Options& o) {
  ViewsPipelineConfig config;
  if (!o.config.empty()) read_toml(o.config, fields(config), MissingKeys::keep_default);
  if (!o.method.empty()) set_field(fields(config), "method=" + o.method);
  for (const std::string& assignment : o.sets) set_field(fields(config), assignment);
  validate(config);
  return config;
}

/// Stages that the pipeline has not would be read and never used.
void check_stages(const std::vector<StageSource>& sources) {
  constexpr const char* kStages[] = {"poses", "splats", "depth", "cloud", "surfaces"};
  for (const StageSource& source : sources) {
    if (std::find(std::begin(kStages), std::end(kStages), source.stage) != std::end(kStages))
      continue;
    std::string all;
    for (const char* stage : kStages) all += (all.empty() ? "" : ", ") + std::string(stage);
    throw std::invalid_argument("--stage " + source.stage + ": pipeline views has " + all);
  }
}

std::string number_of(const std::vector<ScoreRow>& rows, const std::string& metric) {
  for (const ScoreRow& row : rows) {
    if (row.metric != metric) continue;
    char text[64];
    std::snprintf(text, sizeof text, "%.2f %s of %lld views", row.value, row.unit.c_str(),
                  static_cast<long long>(row.n));
    return text;
  }
  return {};
}

std::string summary_of(const ViewsRun& run, std::size_t frames) {
  const auto posed =
      std::count_if(run.estimate.poses.begin(), run.estimate.poses.end(),
                    [](const FramePose& pose) { return pose.status == PoseStatus::ok; });
  std::string text = std::to_string(posed) + " of " + std::to_string(frames) + " views posed, " +
                     std::to_string(run.estimate.splats.splats.size()) + " Gaussians";
  for (const auto& [metric, words] :
       {std::pair("train.psnr", "trained on"), std::pair("held_out.psnr", "held out")}) {
    const std::string number = number_of(run.rows, metric);
    if (!number.empty()) text += ", " + std::string(words) + " " + number;
  }
  return text;
}

}  // namespace

ExitCode command_perceive_views(const JobContext& context) {
  const Options& o = context.options;
  const ViewsPipelineConfig config = config_of(o);
  if (o.keys) {
    ViewsPipelineConfig shown = config;
    std::printf("%s", describe(fields(shown)).c_str());
    return ExitCode::done;
  }
  std::vector<StageSource> sources;
  for (const std::string& stage : o.stages) sources.push_back(parse_stage_source(stage));
  check_stages(sources);
  const PerceivePlaces places = perceive_places(o);
  const Warn warn = [&](const std::string& text) { context.progress.line("warning: " + text); };
  bool all_found = true;
  ScoreFile all;
  for (const fs::path& scene : places.scenes) {
    const Capture capture = read_capture(scene);
    for (const std::string& warning : capture.warnings) warn(warning);
    const int index = scene_index_of(scene);
    const fs::path estimate_dir = places.out / scene_id(index);
    ViewsPipelineConfig written = config;
    write_file(estimate_dir / "config.toml", to_toml(fields(written)));
    const std::string name = scene.filename().string();
    const ViewsRun run = perceive_views(capture, config, o.seed, sources, index, name, estimate_dir,
                                        context.progress.function(), warn);
    context.progress.line(name + ": " + summary_of(run, capture.frames.size()));
    if (run.estimate.splats.splats.empty()) {
      all_found = false;
      std::fprintf(stderr,
                   "cousin: %s: no Gaussians: the photographs showed none of the start or "
                   "nothing to learn\n",
                   scene.string().c_str());
    }
    append({.scores = run.rows}, all);
  }
  if (o.json) {
    std::printf("%s\n", to_json(all).c_str());
  } else {
    print_rows(all.scores);
  }
  context.progress.line("estimates: " + places.out.string());
  return all_found ? ExitCode::done : ExitCode::bad_input;
}

}  // namespace cousin
