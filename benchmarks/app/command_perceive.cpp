// perceive: from a dataset's images to estimates. Reads no truth.
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

#include "benchmarks/app/commands.h"
#include "benchmarks/app/option_keys.h"
#include "benchmarks/app/perceive_places.h"
#include "benchmarks/app/pipeline_options.h"
#include "benchmarks/app/result_output.h"
#include "benchmarks/app/terminal.h"
#include "benchmarks/loop/pipeline_run.h"
#include "benchmarks/loop/specimens_text.h"
#include "benchmarks/report/shown_numbers.h"
#include "benchmarks/tools/measure/measured_page.h"
#include "perception/sfm/sfm_poses.h"
#include "sim/dataset/atomic_file.h"
#include "sim/dataset/capture_io.h"
#include "sim/dataset/manifest.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

// ---- Which pipeline, and how it is configured
// ----------------------------------------------------

std::string pipelines_of_anything() {
  std::string names;
  for (const PipelineRow* each : pipeline_table()) {
    const PipelineRow& row = *each;
    if (row.scenes.empty())
      names += "; --pipeline " + std::string(row.name) + " takes any photographs";
  }
  return names;
}

/// The pipeline that a dataset says it is for.
const PipelineRow& row_of_dataset(const fs::path& dataset, const Capture& capture) {
  const auto manifest = read_manifest(dataset);
  const std::string scene = manifest ? manifest->pipeline : capture.pipeline;
  if (scene.empty())
    throw std::invalid_argument("a real capture names no pipeline: give --pipeline, one of " +
                                pipeline_names());
  if (const PipelineRow* row = pipeline_of_scene(scene)) return *row;
  throw std::invalid_argument(dataset.string() + " is of scene \"" + scene +
                              "\", which has no pipeline yet" + pipelines_of_anything());
}

/// The pipeline, and all that it is told.
struct PerceiveJob {
  const PipelineRow* row = nullptr;
  PipelineConfig config;
  std::vector<StageSource> sources;
};

PerceiveJob perceive_job(const Options& o, const PipelineRow& row) {
  refuse_foreign_options(o, row);
  return {&row, configured_pipeline(o, row.defaults()), stage_sources(o, row)};
}

/// Stages that nobody gives.
void require_outside(const PerceiveJob& job) {
  for (const std::string_view stage : job.row->from_outside) {
    if (replaces(job.sources, stage)) continue;
    const std::string name(stage);
    throw std::invalid_argument("pipeline " + std::string(job.row->name) +
                                " has no stage of its own for " + name + ": give --stage " + name +
                                "=dir:FOLDER or " + name +
                                "=exec:PROGRAM (`cousin run` takes the "
                                "true ones)");
  }
}

// ---- What is printed
// -----------------------------------------------------------------------------

nlohmann::json to_rows(const std::string& scene, const Traits& traits) {
  nlohmann::json rows = nlohmann::json::array();
  for (const SpecimenTraits& specimen : traits) {
    nlohmann::json values;
    for (const Trait& trait : specimen.traits) {
      values[trait.name] = {{"value", trait.value}, {"sigma", trait.sigma}, {"unit", trait.unit}};
    }
    nlohmann::json row = {{"scene", scene},
                          {"instance", specimen.instance},
                          {"status", to_string(specimen.status)},
                          {"reason", specimen.reason},
                          {"traits", values}};
    if (specimen.frame >= 0) row["frame"] = specimen.frame;
    rows.push_back(std::move(row));
  }
  return rows;
}

void print_traits(const std::string& scene, const Traits& traits) {
  for (const SpecimenTraits& specimen : traits) {
    std::printf(
        "%s %s: %s%s", terminal_text(scene).c_str(), name_of(specimen).c_str(),
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

/// What all scenes gave, as it is printed at the end.
struct Printed {
  nlohmann::json traits = nlohmann::json::array();
  ScoreFile rows;
  std::vector<std::string> nothing_found;
  MeasuredPage page;  ///< of real captures of specimens
};

/// A real capture's seeds go into a table and onto a page, as of `measure`.
bool has_page(const Capture& capture, const PipelineRow& row) {
  return capture.pipeline.empty() && row.traits_of == TraitsOf::specimens;
}

void keep_for_page(const Capture& capture, const std::string& name, const PerceivedScene& made,
                   Printed& printed) {
  printed.page.samples.push_back({name, name, made.estimate.traits, unchecked_print()});
  printed.page.scenes.push_back(measured_scene(name, capture, made.estimate));
}

void write_page(const JobContext& context, const PerceiveJob& job, const fs::path& out,
                Printed& printed) {
  MeasuredPage& page = printed.page;
  if (page.samples.empty()) return;
  page.title = "Cousin: " + out.filename().string() + ", measured";
  page.command_line = context.command_line;
  PipelineConfig config = job.config;
  page.config_toml = to_toml(fields(config));
  write_file(out / "specimens.csv", to_tidy_csv(all_rows(page), ""));
  write_file(out / "report.html", make_report(measured_page(page)));
  context.progress.line("table: " + (out / "specimens.csv").string() +
                        "; page: " + (out / "report.html").string());
}

void keep(const Options& o, const std::string& name, const PerceivedScene& made, bool has_traits,
          Printed& printed) {
  append({.scores = made.rows}, printed.rows);
  if (!has_traits) return;
  if (o.json) {
    for (auto& row : to_rows(name, made.estimate.traits)) printed.traits.push_back(std::move(row));
  } else {
    print_traits(name, made.estimate.traits);
  }
}

void print_end(const Options& o, const Printed& printed, bool has_traits) {
  if (has_traits) {
    if (o.json) print_json(printed.traits);
  } else if (o.json) {
    std::printf("%s\n", to_json(printed.rows).c_str());
  } else {
    print_rows(printed.rows.scores);
  }
}

}  // namespace

ExitCode command_perceive(const JobContext& context) {
  const Options& o = context.options;
  std::optional<PerceiveJob> job;
  // Without a name the dataset says which; of keys alone those of the first row are meant.
  if (!o.pipeline.empty() || o.keys)
    job =
        perceive_job(o, o.pipeline.empty() ? *pipeline_table().front() : pipeline_row(o.pipeline));
  if (o.keys) {
    std::printf("%s", describe(fields(job->config)).c_str());
    return ExitCode::done;
  }
  const std::shared_ptr<const LearnedDistance> learned = learned_of(o);
  const PerceivePlaces places = perceive_places(o);
  const Warn warn = [&](const std::string& text) { context.progress.line("warning: " + text); };
  std::optional<OutputFolder> folder;  // taken when the first scene is known to be one of ours
  Printed printed;
  for (const fs::path& scene_dir : places.scenes) {
    const Capture capture = read_capture(scene_dir);
    if (!job) job = perceive_job(o, row_of_dataset(places.dataset, capture));
    require_outside(*job);
    if (needs_sfm(capture, job->config) && !replaces(job->sources, "poses")) require_sfm();
    check_capture(capture, job->config);  // throws here, before any work
    for (const std::string& warning : capture.warnings) warn(warning);
    const std::string name = scene_dir.filename().string();
    const int index = scene_index_of(scene_dir);
    const fs::path estimate_dir = places.out / scene_id(index);
    if (!folder) folder.emplace(estimate_folder(places, has_page(capture, *job->row)));
    PipelineConfig written = job->config;
    write_file(estimate_dir / "config.toml", to_toml(fields(written)));
    const PerceivedScene made = perceive_scene({.capture = capture,
                                                .config = job->config,
                                                .seed = o.seed,
                                                .sources = job->sources,
                                                .scene_index = index,
                                                .name = name,
                                                .estimate_dir = estimate_dir,
                                                .learned = learned.get()},
                                               context.progress.function(), warn);
    context.progress.line(name + ": " + made.summary);
    for (const std::string& text : made.unmeasured) context.progress.line(text);
    keep(o, name, made, !job->row->traits.empty(), printed);
    if (has_page(capture, *job->row)) keep_for_page(capture, name, made, printed);
    if (!made.nothing.empty())
      printed.nothing_found.push_back(scene_dir.string() + ": " + made.summary);
  }
  write_page(context, *job, places.out, printed);
  print_end(o, printed, !job->row->traits.empty());
  context.progress.line("estimates: " + places.out.string());
  for (const std::string& text : printed.nothing_found) print_message("cousin: " + text);
  return printed.nothing_found.empty() ? ExitCode::done : ExitCode::bad_input;
}

}  // namespace cousin
