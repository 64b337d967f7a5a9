// measure: the way of a real capture in one verb, from photographs or a video to a table of sizes.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "benchmarks/app/commands.h"
#include "benchmarks/app/option_keys.h"
#include "benchmarks/app/pipeline_options.h"
#include "benchmarks/app/result_output.h"
#include "benchmarks/app/terminal.h"
#include "benchmarks/loop/pipeline_run.h"
#include "benchmarks/loop/result_folder.h"
#include "benchmarks/score/length_units.h"
#include "benchmarks/tools/measure/board_lens.h"
#include "benchmarks/tools/measure/measured_page.h"
#include "benchmarks/tools/measure/measured_table.h"
#include "benchmarks/tools/measure/sample_source.h"
#include "perception/pipelines/seeds.h"
#include "sim/dataset/atomic_file.h"
#include "sim/dataset/manifest.h"
#include "sim/dataset/output_folder.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

// ---- How it is configured
// ------------------------------------------------------------------------

/// `is_blind`: of photographs without --intrinsics.
PipelineConfig configured(const Options& o, bool is_blind) {
  PipelineConfig start = pipeline_row("seeds").defaults();
  if (is_blind) trust_the_board(*start.get_if<SeedsPipelineConfig>());
  return configured_pipeline(o, start);
}

bool is_blind(const Options& o, const SamplePlace& place) {
  return place.kind != SamplePlace::Kind::scene && o.intrinsics.empty();
}

/// Refuses what would change nothing. @throws std::invalid_argument
void check_options(const Options& o, const std::vector<SamplePlace>& places) {
  const auto has = [&](SamplePlace::Kind kind) {
    return std::any_of(places.begin(), places.end(),
                       [&](const SamplePlace& place) { return place.kind == kind; });
  };
  if (!has(SamplePlace::Kind::video))
    refuse_given(o, {"--frames"}, "is of videos; all photographs of a folder are read");
  if (!has(SamplePlace::Kind::video) && !has(SamplePlace::Kind::photographs))
    refuse_given(o, {"--intrinsics"}, "is of photographs and videos; a dataset has its own lens");
  if (o.ruler.empty()) refuse_given(o, {"--ruler-sigma"}, "is the deviation of --ruler");
  for (const char* column :
       {"sample", "seed", "trait", "unit", "value", "low", "high", "status", "reason"}) {
    if (o.group == column)
      throw std::invalid_argument("--group " + o.group + ": the table has a column of that name");
  }
}

/// All that decides the folder's files but the pictures themselves.
std::string measure_key(const Options& o, const std::vector<SamplePlace>& places) {
  std::string key = std::string(COUSIN_VERSION) + "\n" + o.intrinsics + "\n" + o.ruler + "\n" +
                    std::to_string(o.ruler_sigma_mm) + "\n" + o.group + "\n" +
                    std::to_string(o.frames) + "\n" + std::to_string(o.seed) + "\n";
  for (const SamplePlace& place : places) {
    PipelineConfig config = configured(o, is_blind(o, place));
    key += place.name + "\n" + fs::absolute(place.path).lexically_normal().string() + "\n" +
           to_toml(fields(config));
  }
  return sha256_hex(key);
}

PrintScale scale_of(const Options& o, const Capture& capture) {
  if (!o.ruler.empty()) return print_scale_of_ruler(o.ruler, o.ruler_sigma_mm);
  return capture.pipeline.empty() ? unchecked_print() : exact_print();
}

/// The lens that nobody says is the board's to tell.
void take_board_lens(const std::string& name, const PipelineConfig& config, Capture& capture,
                     const Warn& warn) {
  const auto* seeds = config.get_if<SeedsPipelineConfig>();
  if (!seeds || capture.frames.empty()) return;
  const double assumed_px = capture.frames.front().sensors.front().reported.fx_px;
  const BoardLens lens = take_lens_of_board(*seeds, capture);
  if (lens.views == 0) return;
  char text[160];
  std::snprintf(text, sizeof text,
                ": by the board in %d views the focal length is %.1f px, %.1f px was assumed",
                lens.views, lens.focal_px, assumed_px);
  warn(name + text);
}

// ---- One sample
// ----------------------------------------------------------------------------------

struct Measured {
  MeasuredSample sample;
  ReportScene scene;
  std::string nothing;  ///< why nothing can be measured; empty where something can
};

Measured measure_sample(const JobContext& context, const SamplePlace& place, int index,
                        const fs::path& out, std::vector<std::string>& notes) {
  const Options& o = context.options;
  const Warn warn = [&](const std::string& text) {
    context.progress.line("warning: " + text);
    notes.push_back(text);
  };
  context.progress.line(place.name + ": reading " + place.path.string());
  Capture capture = read_sample(place, {.intrinsics = o.intrinsics, .frames = o.frames});
  PipelineConfig config = configured(o, is_blind(o, place));
  check_capture(capture, config);
  for (const std::string& warning : capture.warnings) warn(warning);
  if (is_blind(o, place)) take_board_lens(place.name, config, capture, warn);
  const fs::path estimate_dir = out / "estimate" / scene_id(index);
  write_file(estimate_dir / "config.toml", to_toml(fields(config)));
  const std::vector<StageSource> no_sources;
  const PerceivedScene made = perceive_scene({.capture = capture,
                                              .config = config,
                                              .seed = o.seed,
                                              .sources = no_sources,
                                              .scene_index = index,
                                              .name = place.name,
                                              .estimate_dir = estimate_dir},
                                             context.progress.function(), warn);
  context.progress.line(place.name + ": " + made.summary);
  for (const std::string& text : made.unmeasured) context.progress.line(text);
  Measured result;
  result.sample = {place.name, place.source, made.estimate.traits, scale_of(o, capture)};
  result.scene = measured_scene(scene_id(index), capture, made.estimate);
  if (!made.nothing.empty()) result.nothing = place.path.string() + ": " + made.summary;
  return result;
}

// ---- What is printed
// -----------------------------------------------------------------------------

nlohmann::json to_json_row(const MeasuredRow& row, const std::string& group) {
  nlohmann::json json = {{"sample", row.sample}, {"seed", row.seed}, {"status", row.status}};
  if (!group.empty()) json[group] = row.source;
  if (row.trait.empty()) {
    json["reason"] = row.reason;
    return json;
  }
  json["trait"] = row.trait;
  json["unit"] = length_unit(row.unit).millimetres;
  json["value"] = row.value;
  json["low"] = row.low;
  json["high"] = row.high;
  return json;
}

void print_seeds(const std::vector<MeasuredRow>& rows) {
  std::string line, last;
  for (const MeasuredRow& row : rows) {
    const std::string seed = terminal_text(row.sample) + " seed " + std::to_string(row.seed);
    if (seed != last) {
      if (!line.empty()) std::printf("%s\n", line.c_str());
      line = seed + ":";
      if (row.trait.empty()) line += " " + row.status + " (" + terminal_text(row.reason) + ")";
      last = seed;
    }
    if (row.trait.empty()) continue;
    char number[64];
    std::snprintf(number, sizeof number, " %.3f", row.value);
    line += "  " + terminal_text(row.trait) + number;
    std::snprintf(number, sizeof number, " ± %.3f", row.high - row.value);
    if (std::isfinite(row.high)) line += number;
    line += " " + std::string(length_unit(row.unit).millimetres);
  }
  if (!line.empty()) std::printf("%s\n", line.c_str());
}

/// Those of which fewer seeds are measured than --expect says.
std::vector<std::string> too_few(const Options& o, const std::vector<MeasuredSample>& samples) {
  std::vector<std::string> lines;
  for (const MeasuredSample& sample : samples) {
    const int measured = count_measured(sample.traits);
    if (measured < o.expect)
      lines.push_back(sample.name + ": " + std::to_string(measured) + " seeds are measured, " +
                      std::to_string(o.expect) + " are expected");
  }
  return lines;
}

fs::path out_of(const Options& o) {
  if (!o.out.empty()) return o.out;
  const fs::path first = fs::path(o.arguments.front()).filename();
  return fs::path("out") / ("measured_" + first.stem().string());
}

}  // namespace

ExitCode command_measure(const JobContext& context) {
  const Options& o = context.options;
  if (o.keys) {
    PipelineConfig config = configured(o, o.intrinsics.empty());
    std::printf("%s", describe(fields(config)).c_str());
    return ExitCode::done;
  }
  if (!o.ruler.empty()) (void)print_scale_of_ruler(o.ruler, o.ruler_sigma_mm);
  const std::vector<SamplePlace> places = sample_places(o.arguments);
  check_options(o, places);
  const FolderClaim claim{.verb = "measure",
                          .version = COUSIN_VERSION,
                          .config = measure_key(o, places),
                          .names = {"estimate", "specimens.csv", "report.html"}};
  const fs::path out = out_of(o);
  require_writable(out);
  check_output_folder(out, claim);
  OutputFolder folder(out, claim);
  MeasuredPage page;
  page.command_line = context.command_line;
  page.group = o.group;
  std::vector<std::string> nothing;
  for (std::size_t i = 0; i < places.size(); ++i) {
    Measured measured = measure_sample(context, places[i], static_cast<int>(i), out, page.notes);
    page.samples.push_back(std::move(measured.sample));
    page.scenes.push_back(std::move(measured.scene));
    if (!measured.nothing.empty()) nothing.push_back(measured.nothing);
    // The table is whole after each sample: what is finished is never lost.
    write_file(out / "specimens.csv", to_tidy_csv(all_rows(page), o.group));
  }
  page.title = "Cousin: " +
               (o.arguments.size() == 1 ? places.front().source
                                        : std::to_string(places.size()) + " samples") +
               ", measured";
  PipelineConfig config = configured(o, is_blind(o, places.front()));
  page.config_toml = to_toml(fields(config));
  write_file(out / "report.html", make_report(measured_page(page)));
  folder.remove_earlier();
  const std::vector<MeasuredRow> rows = all_rows(page);
  if (o.json) {
    nlohmann::json list = nlohmann::json::array();
    for (const MeasuredRow& row : rows) list.push_back(to_json_row(row, o.group));
    print_json(list);
  } else {
    print_seeds(rows);
    for (const ReportTable& table : group_tables(page))
      std::printf("\n%s\n", table_text(table).c_str());
  }
  context.progress.line("table: " + (out / "specimens.csv").string() +
                        "; page: " + (out / "report.html").string());
  for (const std::string& text : nothing) print_message("cousin: " + text);
  const std::vector<std::string> few = too_few(o, page.samples);
  for (const std::string& text : few) print_message("cousin: " + text);
  if (!few.empty()) return ExitCode::gate_failed;
  return nothing.empty() ? ExitCode::done : ExitCode::bad_input;
}

}  // namespace cousin
