// OUT/export.json: {"export": SHA-256 of program version, dataset, format and options, "format",
// "options": {...}}, written last.

#include "sim/dataset/export/export_dataset.h"

#include <array>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/capture_io.h"
#include "sim/dataset/json_interop.h"
#include "sim/dataset/links.h"
#include "sim/dataset/manifest.h"
#include "sim/types/whole_file.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

Json to_json(const ExportOptions& o) {
  Json json = {{"undistort", o.undistort},  {"true_cameras", o.true_cameras},
               {"split", o.split},          {"masks", to_string(o.masks)},
               {"task", to_string(o.task)}, {"least_visible", o.least_visible}};
  if (!o.category.empty()) json["category"] = o.category;
  return json;
}

/// What a dataset is: its manifest, or the indices of a real capture's scenes.
std::string identity(const fs::path& dataset, const std::vector<fs::path>& scenes) {
  if (fs::exists(dataset / "manifest.json")) return sha256_hex_of_file(dataset / "manifest.json");
  std::string hashes;
  for (const fs::path& scene : scenes) {
    for (const char* name : {"rig.json", "scene_camera.json"})
      hashes += sha256_hex_of_file(scene / name) + "\n";
  }
  return sha256_hex(hashes);
}

/// One that was stopped before its end by a program that marked the folder so.
constexpr const char* kPartialFile = "partial.json";

/// Files that say, outside the list of what the export wrote, that the folder is this export's.
/// @throws std::invalid_argument if one says that it is another's.
std::vector<std::pair<std::string, std::string>> own_marks(const fs::path& out,
                                                           const std::string& key) {
  std::vector<std::pair<std::string, std::string>> own;
  for (const char* name : {"export.json", kPartialFile}) {
    const fs::path file = out / name;
    if (!fs::is_regular_file(fs::symlink_status(file))) continue;
    const auto json = nlohmann::json::parse(read_file(file), nullptr, false);
    if (!json.is_object() || !json.contains("export") || json["export"] != key) {
      throw std::invalid_argument(file.string() +
                                  " is of another dataset, format or choice of options, or of "
                                  "another version of the program; choose another --out");
    }
    own.emplace_back(name, sha256_hex_of_file(file));
  }
  return own;
}

}  // namespace

FolderClaim export_claim(const std::string& key, const std::string& program_version) {
  return {.verb = "export",
          .version = program_version,
          .config = key,
          .names = {"*"},
          .other_config = FolderClaim::OtherConfig::refuse};
}

std::span<const ExportFormat> export_formats() {
  static const std::array<ExportFormat, 10> kFormats = {{{"bop", export_bop},
                                                         {"coco", export_coco},
                                                         {"yolo", export_yolo},
                                                         {"colmap", export_colmap},
                                                         {"nerfstudio", export_nerfstudio},
                                                         {"tum", export_tum},
                                                         {"opencv", export_opencv},
                                                         {"ros", export_ros},
                                                         {"kalibr", export_kalibr},
                                                         {"mrcal", export_mrcal}}};
  return kFormats;
}

ExportSummary export_dataset(const fs::path& dataset, const ExportFormat& format,
                             const ExportOptions& options, const fs::path& out,
                             const std::string& program_version, const ExportProgress& progress) {
  const std::vector<fs::path> folders = scene_folders(dataset);
  if (folders.empty())
    throw std::runtime_error(dataset.string() + ": holds no scene (000000/rig.json)");
  ExportJob job{.scenes = {}, .options = options, .out = out, .progress = progress, .warnings = {}};
  for (std::size_t i = 0; i < folders.size(); ++i) {
    progress("read scenes", static_cast<int>(i), static_cast<int>(folders.size()));
    refuse_links_out(dataset, folders[i].filename());
    job.scenes.push_back(read_export_scene(folders[i]));
  }
  const Json chosen = to_json(options);
  const std::string key = sha256_hex(program_version + "\n" + identity(dataset, folders) + "\n" +
                                     format.name + "\n" + chosen.dump());
  const bool is_new = !fs::exists(out);
  try {
    const OutputFolder folder(out, export_claim(key, program_version), own_marks(out, key));
    format.write(job);
    Json root = {{"export", key}, {"format", format.name}, {"options", chosen}};
    write_file(out / "export.json", to_text(root));
    remove_own(out / kPartialFile);
  } catch (...) {
    std::error_code not_empty;  // a refusal leaves no trace
    if (is_new) fs::remove(out, not_empty);
    throw;
  }
  return {static_cast<int>(job.scenes.size()), picture_count(job.scenes), std::move(job.warnings)};
}

std::vector<const ExportPicture*> first_pictures(const ExportScene& scene) {
  std::vector<const ExportPicture*> pictures;
  for (const ExportPicture& picture : scene.pictures) {
    if (picture.sensor == 0) pictures.push_back(&picture);
  }
  if (pictures.empty() && !scene.capture.frames.empty()) {
    throw std::runtime_error(scene.folder.string() + ": the first sensor, \"" +
                             scene.capture.rig.front().name +
                             "\", has no pictures, and labels are of these");
  }
  return pictures;
}

std::vector<const ExportPicture*> labelled_pictures(const ExportScene& scene) {
  std::vector<const ExportPicture*> pictures = first_pictures(scene);
  if (!scene.truth) return pictures;
  for (const SensorViews& other : scene.truth->other_sensors) {
    if (other.images.empty()) continue;
    for (const ExportPicture& picture : scene.pictures) {
      if (picture.sensor > 0 && scene.capture.rig[picture.sensor].name == other.sensor)
        pictures.push_back(&picture);
    }
  }
  return pictures;
}

std::int64_t picture_id(const ExportScene& scene, const ExportPicture& picture) {
  constexpr std::int64_t kFrames = 1'000'000, kScenes = 1'000'000;
  return kFrames * (kScenes * static_cast<std::int64_t>(picture.sensor) + scene.number) +
         scene.capture.frames[picture.frame].id;
}

std::string picture_name(const ExportScene& scene, const ExportPicture& picture) {
  const std::string frame =
      six_digits(scene.number) + "_" + six_digits(scene.capture.frames[picture.frame].id);
  return picture.sensor == 0 ? frame : frame + "_" + scene.capture.rig[picture.sensor].name;
}

int picture_count(const std::vector<ExportScene>& scenes) {
  std::size_t count = 0;
  for (const ExportScene& scene : scenes) count += scene.pictures.size();
  return static_cast<int>(count);
}

}  // namespace cousin
