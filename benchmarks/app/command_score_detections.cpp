// score DATASET FILE: boxes and masks that somebody's detector found.
#include <filesystem>
#include <optional>
#include <string>

#include "benchmarks/app/commands.h"
#include "benchmarks/app/dataset_check.h"
#include "benchmarks/app/option_keys.h"
#include "benchmarks/app/result_output.h"
#include "benchmarks/app/terminal.h"
#include "benchmarks/loop/result_folder.h"
#include "benchmarks/loop/score_seeds.h"
#include "benchmarks/tools/detections/detections_report.h"
#include "sim/dataset/atomic_file.h"
#include "sim/dataset/capture_io.h"
#include "sim/dataset/manifest.h"
#include "sim/dataset/output_folder.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

/// What the file says of the pictures that it is scored on.
FoundFile read_found_of(const JobContext& context, const fs::path& file, TruePictures& truth) {
  FoundFile found = read_found(file, truth.names);
  if (found.has_masks && !truth.has_masks) {
    found.has_masks = false;
    context.progress.line("masks are not scored: not all labels have one");
  }
  if (const std::size_t out = leave_out_sensors(truth, found); out > 0) {
    context.progress.line(std::to_string(out) +
                          " pictures of sensors that the file names no picture of are left out");
  }
  return found;
}

}  // namespace

ExitCode command_score_detections(const JobContext& context) {
  const Options& o = context.options;
  const fs::path dataset = o.arguments.at(0), path = o.arguments.at(1);
  refuse_given(o, {"--align"}, "is of estimates with poses; boxes have none");
  DetectionScoreConfig config;
  config.confidence = o.confidence;
  config.seed = o.seed;
  config.classes = class_map_from_string(o.class_map);
  config.is_from_zero = fs::is_directory(path);  // YOLO's text
  for (const std::string& gate : o.gates) parse_gate(gate);
  const fs::path out =
      o.out.empty() ? fs::path("out") / (path.stem().string() + "_scores") : fs::path(o.out);
  const FolderClaim claim{.verb = "score",
                          .version = COUSIN_VERSION,
                          .config = {},
                          .names = result_names({"report.html"})};
  check_output_folder(out, claim);
  require_writable(out);
  if (const std::optional<Manifest> manifest = read_manifest(dataset)) {
    for (const fs::path& scene : scene_folders(dataset))
      check_unchanged(dataset, *manifest, scene.filename());
  }
  TruePictures truth = read_true_pictures(dataset, o.category, [&](int done, int all) {
    context.progress.function()("read labels", done, all);
  });
  const FoundFile found = read_found_of(context, path, truth);
  if (config.classes.empty() && !config.is_from_zero) config.classes = truth.class_numbers;
  ScoreRow base;
  base.suite = "score";
  base.scene = dataset.filename().string();
  base.method = path.filename().string();
  base.seed = o.seed;
  const DetectionScores scores = score_detections(truth, found, config, base);

  ScoreFile file;
  file.header.program_version = COUSIN_VERSION;
  file.header.machine = machine_text();
  if (fs::exists(dataset / "manifest.json"))
    file.header.dataset_hash = sha256_hex_of_file(dataset / "manifest.json");
  file.header.more["command"] = context.command_line;
  file.scores = scores.rows;
  ReportInput report = detections_report(truth, found, scores, config, file);
  file.header.more["title"] = report.scores.header.more["title"] = report.title;
  file.header.more["summary"] = report.scores.header.more["summary"] = report.summary;
  report.commands = {context.command_line};
  const OutputFolder folder(out, claim);
  write_result_tables(out, file);
  write_file(out / "report.html", make_report(report));
  if (o.json) {
    print_result(o, file);
  } else {
    for (const ReportTable& table : report.tables) {
      if (table.title != kMissedTitle) print_result_lines(table_text(table) + "\n");
    }
  }
  context.progress.line(report.summary);
  context.progress.line("report: " + (out / "report.html").string());
  return check_gates(o, file.scores);
}

}  // namespace cousin
