// import: captures of others become datasets.
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "benchmarks/app/commands.h"
#include "benchmarks/app/result_output.h"
#include "benchmarks/tools/import/import_capture.h"
#include "sim/dataset/capture_io.h"
#include "sim/dataset/categories.h"
#include "sim/dataset/manifest.h"
#include "sim/dataset/output_folder.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

/// All that decides what a capture becomes, but the capture itself.
std::string import_key(const ImportRequest& request) {
  std::string key = std::string(COUSIN_VERSION) + "\n" + request.format + "\n" +
                    fs::absolute(request.source).lexically_normal().string() + "\n" +
                    std::to_string(request.depth_unit_m.value_or(0)) + "\n" +
                    std::to_string(request.length_unit_m.value_or(0)) + "\n" +
                    std::to_string(request.frames) + "\n";
  const fs::path intrinsics = request.intrinsics;
  if (fs::is_regular_file(intrinsics)) key += sha256_hex_of_file(intrinsics);
  return sha256_hex(key);
}

}  // namespace

ExitCode command_import(const JobContext& context) {
  const Options& o = context.options;
  const fs::path source = o.arguments.at(0);
  ImportRequest request{.format = o.format, .source = source, .intrinsics = o.intrinsics};
  if (o.depth_unit_m > 0) request.depth_unit_m = o.depth_unit_m;
  if (o.length_unit_m > 0) request.length_unit_m = o.length_unit_m;
  request.frames = o.frames;
  const fs::path dataset = o.out.empty() ? fs::path("out") / source.filename() : fs::path(o.out);
  const FolderClaim claim{.verb = "import",
                          .version = COUSIN_VERSION,
                          .config = import_key(request),
                          .names = {"######", kCategoriesFile, "manifest.json", "manifest.*.json"},
                          .other_config = FolderClaim::OtherConfig::refuse};
  check_output_folder(dataset, claim);
  const bool is_labelled = has_labels(request);
  LabelledPhotographs labelled;
  if (is_labelled)
    labelled = import_labelled(request);
  else
    labelled.capture = import_capture(request);
  const Capture& capture = labelled.capture;
  for (const std::string& warning : capture.warnings) context.progress.line("warning: " + warning);
  OutputFolder folder(dataset, claim);
  write_capture(dataset / scene_id(0), capture);
  if (is_labelled) {
    write_labels(dataset / scene_id(0), labelled.labels, 0);
    write_categories(dataset, labelled.categories);
  }
  folder.remove_earlier();  // pictures that the source has no longer
  if (o.json) {
    nlohmann::json result = {{"dataset", dataset.string()},
                             {"frames", capture.frames.size()},
                             {"warnings", capture.warnings}};
    if (is_labelled) result["labels"] = labelled.labels.boxes.size();
    print_json(result);
  }
  context.progress.line(
      "dataset: " + dataset.string() + ", " + std::to_string(capture.frames.size()) + " frames, " +
      (is_labelled ? std::to_string(labelled.labels.boxes.size()) + " labels, " : std::string()) +
      std::to_string(capture.warnings.size()) + " warnings");
  return ExitCode::done;
}

}  // namespace cousin
