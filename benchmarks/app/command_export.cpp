// export: a dataset as other programs read it.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "benchmarks/app/commands.h"
#include "benchmarks/app/option_keys.h"
#include "benchmarks/app/result_output.h"
#include "benchmarks/loop/result_folder.h"
#include "benchmarks/loop/scene_table.h"
#include "benchmarks/loop/simulate.h"
#include "benchmarks/tools/kit/print_kit.h"
#include "sim/dataset/atomic_file.h"
#include "sim/dataset/capture_io.h"
#include "sim/dataset/export/export_dataset.h"
#include "sim/dataset/manifest.h"
#include "sim/dataset/truth_io.h"
#include "sim/render/cycles/cycles.h"
#include "sim/render/cycles/plain_scene.h"
#include "sim/types/whole_file.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

const ExportFormat* find_format(const std::string& name) {
  for (const ExportFormat& format : export_formats()) {
    if (format.name == name) return &format;
  }
  return nullptr;
}

[[noreturn]] void refuse_format(const std::string& name) {
  std::string names;
  for (const ExportFormat& format : export_formats()) names += format.name + ", ";
  throw std::invalid_argument("--format \"" + name + "\" is not one of " + names + "gltf, blend");
}

/// Options that some formats read and others do not.
struct FormatOption {
  const char* option;
  std::vector<std::string_view> formats;
};
const std::vector<FormatOption>& format_options() {
  static const std::vector<std::string_view> kPictures = {
      "bop", "coco", "yolo", "colmap", "nerfstudio", "tum", "opencv", "ros", "kalibr", "mrcal"};
  static const std::vector<FormatOption> kOptions = {{"--undistort", kPictures},
                                                     {"--true-cameras", kPictures},
                                                     {"--split", {"bop", "coco", "yolo"}},
                                                     {"--masks", {"coco"}},
                                                     {"--task", {"yolo"}},
                                                     {"--category", {"coco", "yolo"}},
                                                     {"--least-visible", {"coco", "yolo"}}};
  return kOptions;
}

/// @throws std::invalid_argument naming an option that is given and that the format does not read.
void check_format_reads(const Options& o) {
  std::string has;
  const auto reads = [&](const FormatOption& row) {
    return std::find(row.formats.begin(), row.formats.end(), o.format) != row.formats.end();
  };
  for (const FormatOption& row : format_options()) {
    if (reads(row)) has += (has.empty() ? "" : ", ") + std::string(row.option);
  }
  for (const FormatOption& row : format_options()) {
    if (reads(row)) continue;
    std::string formats;
    for (const std::string_view format : row.formats)
      formats += (formats.empty() ? "" : ", ") + std::string(format);
    refuse_given(o, {row.option},
                 "is of --format " + formats + "; " + o.format + " takes " +
                     (has.empty() ? "none of these options" : has));
  }
}

bool same_places(const Scene& a, const Scene& b) {
  if (a.instances.size() != b.instances.size()) return false;
  for (std::size_t i = 0; i < a.instances.size(); ++i) {
    const Pose &p = a.instances[i].world_from_object, &q = b.instances[i].world_from_object;
    if (a.instances[i].name != b.instances[i].name) return false;
    if ((p.translation_m - q.translation_m).norm() > 1e-9) return false;
    if (angle_rad(p.rotation * q.rotation.conjugate()) > 1e-6) return false;
  }
  return true;
}

/// The scene with its vertex colours and normals, which files do not keep: made again from the
/// configuration and seed, and compared with the files.
Scene shaded_scene(const SceneTruth& truth, const fs::path& scene_dir, ProgressPrinter& progress) {
  std::string why;
  try {
    const RunConfig config = run_config(built_row(scene_entry(truth.scene.name)), {},
                                        scene_dir / "truth" / "config.toml");
    const int index = std::stoi(scene_dir.filename().string());
    Scene made = built_scene(cousin_of(config, truth.seed, index).config, truth.seed, index);
    if (same_places(made, truth.scene)) return made;
    why = "this version of the program makes another scene of its configuration";
  } catch (const std::exception& error) {
    why = error.what();
  }
  progress.line("warning: " + scene_dir.string() + ": without vertex colours and normals (" + why +
                ")");
  return truth.scene;
}

/// What a dataset is: its manifest, or its place.
std::string identity(const fs::path& dataset) {
  const fs::path manifest = dataset / "manifest.json";
  return fs::exists(manifest) ? sha256_hex_of_file(manifest)
                              : fs::absolute(dataset).lexically_normal().string();
}

/// blend and gltf: written by Blender.
ExitCode export_scenes(const JobContext& context, const fs::path& out) {
  const Options& o = context.options;
  const SceneFile format = o.format == "blend" ? SceneFile::blend : SceneFile::gltf;
  const fs::path dataset = o.arguments.at(0);
  const std::vector<fs::path> scenes = scene_folders(dataset);
  if (scenes.empty())
    throw std::runtime_error(dataset.string() + ": holds no scene (000000/rig.json)");
  for (const fs::path& scene_dir : scenes) {
    if (!fs::is_directory(scene_dir / "truth")) {
      throw std::runtime_error(scene_dir.string() +
                               ": there is no truth/, which holds the scene; " + o.format +
                               " needs a simulated dataset with its truth");
    }
  }
  CyclesConfig cycles;
  if (!has_cycles(cycles.program)) {
    throw std::runtime_error("--format " + o.format + " is written by Blender, and \"" +
                             cycles.program +
                             "\" cannot be started: install Blender 3.4 (apt install blender)");
  }
  require_writable(out);
  const OutputFolder folder(out, export_claim(sha256_hex(std::string(COUSIN_VERSION) + "\n" +
                                                         identity(dataset) + "\n" + o.format),
                                              COUSIN_VERSION));
  nlohmann::json files = nlohmann::json::array();
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const std::string id = scenes[i].filename().string();
    context.progress("export " + id, static_cast<int>(i), static_cast<int>(scenes.size()));
    const SceneTruth truth = read_truth(scenes[i]);
    if (truth.views.empty())
      throw std::runtime_error((scenes[i] / "truth/camera.json").string() + ": has no view");
    const PlainScene plain =
        plain_scene(shaded_scene(truth, scenes[i], context.progress), truth.views.front());
    for (const std::string& change : plain.changes) context.progress.line(id + ": " + change);
    const fs::path file = out / (id + (format == SceneFile::blend ? ".blend" : ".glb"));
    const PartFolder work(out / id);
    cycles.folder = work.path();
    const fs::path made = work.path() / file.filename();
    save_with_blender(plain.scene, plain.view, cycles, format, made);
    write_file(file, read_file(made, std::size_t{1} << 36));
    files.push_back(file.string());
    context.progress.line(file.string());
  }
  if (o.json) print_json({{"files", files}});
  return ExitCode::done;
}

ExitCode export_view(const JobContext& context, const ExportFormat& format, const fs::path& out) {
  const Options& o = context.options;
  ExportOptions options;
  options.undistort = o.undistort;
  options.true_cameras = o.true_cameras;
  options.split = split_from_string(o.split);
  options.masks = mask_code_from_string(o.masks);
  options.task = yolo_task_from_string(o.task);
  options.category = o.category;
  options.least_visible = o.least_visible;
  const ExportSummary summary = export_dataset(o.arguments.at(0), format, options, out,
                                               COUSIN_VERSION, context.progress.function());
  for (const std::string& warning : summary.warnings) context.progress.line("warning: " + warning);
  if (o.json) {
    print_json({{"folder", out.string()},
                {"scenes", summary.scenes},
                {"pictures", summary.pictures},
                {"warnings", summary.warnings}});
  }
  context.progress.line(format.name + ": " + out.string() + ", " + std::to_string(summary.scenes) +
                        " scenes, " + std::to_string(summary.pictures) + " pictures");
  return ExitCode::done;
}

/// Objects for a 3D printer.
ExitCode export_kit(const JobContext& context) {
  const Options& o = context.options;
  refuse_given(o,
               {"--undistort", "--true-cameras", "--split", "--masks", "--task", "--category",
                "--least-visible"},
               "is of datasets; `cousin export kit` takes none of them");
  const fs::path out = o.out.empty() ? fs::path("out/kit") : fs::path(o.out);
  const std::vector<KitObject> objects = print_kit(o.seed);
  require_writable(out);
  const FolderClaim claim = {
      .verb = "export",
      .version = COUSIN_VERSION,
      .config = sha256_hex(std::string(COUSIN_VERSION) + "\nkit\n" + std::to_string(o.seed)),
      .names = print_kit_files(objects)};
  const OutputFolder folder(out, claim);
  write_print_kit(out, objects);
  if (o.json) print_json({{"folder", out.string()}, {"files", print_kit_files(objects)}});
  context.progress.line("kit: " + out.string() + ", " + std::to_string(objects.size()) +
                        " STL files in millimetres, traits.csv, README.txt");
  return ExitCode::done;
}

}  // namespace

ExitCode command_export(const JobContext& context) {
  const Options& o = context.options;
  if (o.format.empty() && o.arguments.at(0) == "kit") return export_kit(context);
  if (o.format.empty())
    throw std::invalid_argument("--format is required for a dataset; see `cousin export --help`");
  const ExportFormat* format = find_format(o.format);
  if (format == nullptr && o.format != "blend" && o.format != "gltf") refuse_format(o.format);
  check_format_reads(o);
  const fs::path out =
      o.out.empty() ? fs::path(o.arguments.at(0) + "_" + o.format) : fs::path(o.out);
  return format != nullptr ? export_view(context, *format, out) : export_scenes(context, out);
}

}  // namespace cousin
