#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "sim/dataset/export/export_scene.h"
#include "sim/dataset/output_folder.h"

namespace cousin {

/// Called as pictures are done.
using ExportProgress = std::function<void(const std::string& what, int done, int total)>;

/// What a format is made from.
struct ExportJob {
  std::vector<ExportScene> scenes;
  ExportOptions options;
  std::filesystem::path out;
  ExportProgress progress;
  std::vector<std::string> warnings;  ///< what a format left out or changed
};

/// A row of `cousin export --format`.
struct ExportFormat {
  std::string name;
  void (*write)(ExportJob& job);
};
/// To add a format, add a row. @throws of `write`: std::invalid_argument naming what the format
/// cannot hold, std::runtime_error for files.
std::span<const ExportFormat> export_formats();
void export_bop(ExportJob& job);
void export_coco(ExportJob& job);
void export_yolo(ExportJob& job);
void export_colmap(ExportJob& job);
void export_nerfstudio(ExportJob& job);
void export_tum(ExportJob& job);
void export_opencv(ExportJob& job);
void export_ros(ExportJob& job);
void export_kalibr(ExportJob& job);
void export_mrcal(ExportJob& job);

/// The folder of an export is its alone. @param key  SHA-256 of all that decides it
FolderClaim export_claim(const std::string& key, const std::string& program_version);

struct ExportSummary {
  int scenes = 0;
  int pictures = 0;  ///< that the scenes have
  std::vector<std::string> warnings;
};
/// Writes the view of a dataset into `out`, every file beside its name and then renamed.
/// export.json says, last, what the folder holds: the same export again changes nothing and
/// completes one that was stopped.
/// @param program_version  part of what the folder belongs to.
/// @throws std::invalid_argument if `out` holds anything else, or as the format.
ExportSummary export_dataset(const std::filesystem::path& dataset, const ExportFormat& format,
                             const ExportOptions& options, const std::filesystem::path& out,
                             const std::string& program_version, const ExportProgress& progress);

/// The first sensor's pictures of a scene.
std::vector<const ExportPicture*> first_pictures(const ExportScene& scene);
/// Those, and after them the pictures of each other sensor that truth is of.
std::vector<const ExportPicture*> labelled_pictures(const ExportScene& scene);
/// A number of a picture that is one of a whole dataset's: 1,000,000 scene + frame, and of another
/// sensor than the first 1,000,000,000,000 times its place in the rig more.
std::int64_t picture_id(const ExportScene& scene, const ExportPicture& picture);
/// The same for people, "000001_000012", of another sensor "000001_000012_right".
std::string picture_name(const ExportScene& scene, const ExportPicture& picture);
/// Pictures of all scenes.
int picture_count(const std::vector<ExportScene>& scenes);

}  // namespace cousin
