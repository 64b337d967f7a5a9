// perceive --pipeline views: Gaussians of photographs of anything.
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "benchmarks/app/commands.h"
#include "benchmarks/app/perceive_places.h"
#include "benchmarks/app/result_output.h"
#include "benchmarks/app/terminal.h"
#include "benchmarks/app/views_options.h"
#include "perception/sfm/sfm_poses.h"
#include "sim/dataset/atomic_file.h"
#include "sim/dataset/capture_io.h"

namespace cousin {
namespace fs = std::filesystem;
ExitCode command_perceive_views(const JobContext& context) {
  const Options& o = context.options;
  const ViewsPipelineConfig config = views_config(o, o.config, o.sets);
  if (o.keys) {
    ViewsPipelineConfig shown = config;
    std::printf("%s", describe(fields(shown)).c_str());
    return ExitCode::done;
  }
  const std::vector<StageSource> sources = views_sources(o);
  const std::shared_ptr<const LearnedDistance> learned = learned_of(o);
  const PerceivePlaces places = perceive_places(o);
  const Warn warn = [&](const std::string& text) { context.progress.line("warning: " + text); };
  bool all_found = true;
  std::optional<OutputFolder> folder;  // taken when the first scene has been read
  ScoreFile all;
  for (const fs::path& scene : places.scenes) {
    const Capture capture = read_capture(scene);
    for (const std::string& warning : capture.warnings) warn(warning);
    if (needs_sfm(capture, config) && !replaces(sources, "poses")) require_sfm();
    const int index = scene_index_of(scene);
    const fs::path estimate_dir = places.out / scene_id(index);
    if (!folder) folder.emplace(estimate_folder(places));
    ViewsPipelineConfig written = config;
    write_file(estimate_dir / "config.toml", to_toml(fields(written)));
    const std::string name = scene.filename().string();
    const ViewsRun run = perceive_views(capture, config, o.seed, sources, index, name, estimate_dir,
                                        context.progress.function(), warn, learned.get());
    context.progress.line(name + ": " + views_summary(run, capture.frames.size()));
    if (run.estimate.splats.splats.empty()) {
      all_found = false;
      print_message("cousin: " + scene.string() + ": " + no_gaussians_text(run.estimate.splats));
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
