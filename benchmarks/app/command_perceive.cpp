#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

#include "benchmarks/app/commands.h"
#include "benchmarks/app/option_keys.h"
#include "benchmarks/app/perceive_places.h"
#include "benchmarks/app/result_output.h"
#include "benchmarks/app/specimens_text.h"
#include "benchmarks/app/terminal.h"
#include "benchmarks/app/views_options.h"
#include "benchmarks/report/shown_numbers.h"
#include "benchmarks/scenes/scene_table.h"
#include "benchmarks/seeds/perceive.h"
#include "benchmarks/seeds/run_config.h"
#include "perception/sfm/sfm_poses.h"
#include "sim/dataset/atomic_file.h"
#include "sim/dataset/capture_io.h"
#include "sim/dataset/manifest.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

std::string pipeline_of(const Options& options, const Capture& capture, const fs::path& dataset) {
  std::string name = options.pipeline;
  if (name.empty()) {
    const auto manifest = read_manifest(dataset);
    name = manifest ? manifest->pipeline : capture.pipeline;
  }
  if (name.empty())
    throw std::invalid_argument("a real capture names no pipeline: give --pipeline seeds or views");
  for (const SceneEntry& scene : scene_table()) {
    if (scene.name != name || scene.has_pipeline) continue;
    throw std::invalid_argument(dataset.string() + " is of scene \"" + name +
                                "\", which has no pipeline yet; --pipeline views trains "
                                "Gaussians on any photographs");
  }
  if (name != "seeds")
    throw std::invalid_argument("--pipeline \"" + name + "\" is not one of: seeds, views");
  return name;
}

SeedsPipelineConfig seeds_config(const Options& o) {
  const KeyOption method{"--method", "method", o.method};
  return read_config(o, {method}, [&] {
    SeedsPipelineConfig config;
    if (!o.config.empty()) read_toml(o.config, fields(config), MissingKeys::keep_default);
    if (!method.value.empty()) set_field(fields(config), method.assignment());
    for (const std::string& assignment : o.sets) {
      constexpr std::string_view kPrefix = "pipeline.";
      set_field(fields(config),
                assignment.starts_with(kPrefix) ? assignment.substr(kPrefix.size()) : assignment);
    }
    validate(config);
    return config;
  });
}

nlohmann::json to_rows(const std::string& scene, const Traits& traits) {
  nlohmann::json rows = nlohmann::json::array();
  for (const SpecimenTraits& specimen : traits) {
    nlohmann::json values;
    for (const Trait& trait : specimen.traits) {
      values[trait.name] = {{"value", trait.value}, {"sigma", trait.sigma}, {"unit", trait.unit}};
    }
    rows.push_back({{"scene", scene},
                    {"instance", specimen.instance},
                    {"status", to_string(specimen.status)},
                    {"reason", specimen.reason},
                    {"traits", values}});
  }
  return rows;
}

void print_traits(const std::string& scene, const Traits& traits) {
  for (const SpecimenTraits& specimen : traits) {
    std::printf(
        "%s seed %d: %s%s", terminal_text(scene).c_str(), specimen.instance,
        std::string(to_string(specimen.status)).c_str(),
        specimen.reason.empty() ? "" : (" (" + terminal_text(specimen.reason) + ")").c_str());
    for (const Trait& trait : specimen.traits) {
      const ShownUnit shown = shown_unit(trait.unit, trait.name);
      std::printf(shown.factor == 1 ? "  %s %.6g %s" : "  %s %.3f %s",
                  terminal_text(trait.name).c_str(), trait.value * shown.factor,
                  terminal_text(shown.name).c_str());
    }
    std::printf("\n");
  }
}

/// Where all of the views are, and nothing was found from Gaussians.
std::string why_no_splats(const Estimate& estimate, const SeedsPipelineConfig& config) {
  const std::string count = std::to_string(estimate.splats.splats.size());
  if (estimate.splats.splats.empty()) return no_gaussians_text(estimate.splats);
  if (config.method == SeedsMethod::splats_paper)
    return "of " + count + " Gaussians none has its centre in the volume and an opacity of " +
           "splats.least_opacity";
  return "the depths of " + count + " Gaussians agree in no views";
}

/// Which stage found nothing first, if there is no specimen.
std::string why_nothing(const Estimate& estimate, const SeedsPipelineConfig& config, int posed) {
  if (!estimate.cloud.empty() || !estimate.clusters.cloud.empty())
    return estimate.traits.empty() ? "nothing stands on the board"
                                   : "no object has enough points of the cloud";
  if (posed == 0) {
    const auto seen = std::count_if(
        estimate.corners.begin(), estimate.corners.end(),
        [](const FrameCorners& corners) { return corners.status == BoardStatus::ok; });
    const bool no_image = std::all_of(
        estimate.corners.begin(), estimate.corners.end(),
        [](const FrameCorners& corners) { return corners.status == BoardStatus::no_image; });
    if (!estimate.corners.empty() && no_image) return "the capture has no colour images";
    return seen == 0 ? "no view shows the board"
                     : std::to_string(seen) + " views show the board, but none could be posed";
  }
  if (config.method == SeedsMethod::splats || config.method == SeedsMethod::splats_paper)
    return why_no_splats(estimate, config);
  const bool some_depth =
      std::any_of(estimate.depths.begin(), estimate.depths.end(), [](const FrameDepth& frame) {
        return std::any_of(frame.depth_m.begin(), frame.depth_m.end(),
                           [](float depth_m) { return !std::isnan(depth_m); });
      });
  return some_depth ? "the views agree on no depth"
                    : "no view has depth, which takes more views beside it";
}

/// Whether no stage found anything that could be measured; what is only seen has no cluster.
bool found_nothing(const Estimate& estimate) {
  if (estimate.traits.empty()) return true;
  const std::vector<int>& instance = estimate.clusters.instance;
  return std::all_of(instance.begin(), instance.end(), [](int i) { return i < 0; }) &&
         std::none_of(estimate.traits.begin(), estimate.traits.end(),
                      [](const SpecimenTraits& s) { return s.status == TraitStatus::ok; });
}

/// Says which views have no pose and why; the number of those that have one.
int count_posed(const Poses& poses, const Corners& corners, ProgressPrinter& progress) {
  int posed = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (poses[i].status == PoseStatus::ok) {
      ++posed;
      continue;
    }
    std::string why(to_string(poses[i].status));
    if (i < corners.size() && corners[i].status != BoardStatus::ok) {
      why += " (" + std::string(to_string(corners[i].status)) + ")";
    }
    progress.line("warning: view " + std::to_string(poses[i].frame) + " has no pose: " + why);
  }
  return posed;
}

}  // namespace

ExitCode command_perceive(const JobContext& context) {
  const Options& o = context.options;
  if (o.pipeline == "views") return command_perceive_views(context);
  refuse_given(o, {"--lpips"}, "is of --pipeline views");
  SeedsPipelineConfig config = seeds_config(o);
  if (o.keys) {
    std::printf("%s", describe(fields(config)).c_str());
    return ExitCode::done;
  }
  std::vector<StageSource> sources;
  for (const std::string& stage : o.stages)
    sources.push_back(parse_stage_source(stage, o.stage_time_limit_s));
  check_stages(sources, seeds_stage_order(), "seeds");

  if (needs_sfm(config) && !replaces(sources, "poses")) require_sfm();
  const PerceivePlaces places = perceive_places(o);
  const fs::path& dataset = places.dataset;
  const fs::path& out = places.out;
  const Warn warn = [&](const std::string& text) { context.progress.line("warning: " + text); };
  std::optional<OutputFolder> folder;  // taken when the first scene is known to be one of ours
  std::vector<std::string> nothing_found;
  nlohmann::json rows = nlohmann::json::array();
  for (const fs::path& scene_dir : places.scenes) {
    const Capture capture = read_capture(scene_dir);
    pipeline_of(o, capture, dataset);
    board_of(capture, config);  // throws here, before any work, if there is none
    for (const std::string& warning : capture.warnings) warn(warning);
    const std::string name = scene_dir.filename().string();
    const int index = scene_index_of(scene_dir);
    const fs::path estimate_dir = out / scene_id(index);
    if (!folder) folder.emplace(estimate_folder(places));
    write_file(estimate_dir / "config.toml", to_toml(fields(config)));
    const Estimate estimate = perceive_seeds(capture, config, o.seed, sources, index, estimate_dir,
                                             context.progress.function(), warn);
    const int posed = count_posed(estimate.poses, estimate.corners, context.progress);
    std::string summary = std::to_string(posed) + " of " + std::to_string(capture.frames.size()) +
                          " views posed, " + specimens_text(estimate.traits);
    const bool nothing = found_nothing(estimate);
    if (nothing) summary += ": " + why_nothing(estimate, config, posed);
    context.progress.line(name + ": " + summary);
    for (const std::string& text : unmeasured_lines(estimate.traits)) context.progress.line(text);
    if (nothing) nothing_found.push_back(scene_dir.string() + ": " + summary);
    if (o.json) {
      for (auto& row : to_rows(name, estimate.traits)) rows.push_back(std::move(row));
    } else {
      print_traits(name, estimate.traits);
    }
  }
  if (o.json) print_json(rows);
  context.progress.line("estimates: " + out.string());
  for (const std::string& text : nothing_found) print_message("cousin: " + text);
  return nothing_found.empty() ? ExitCode::done : ExitCode::bad_input;
}

}  // namespace cousin
