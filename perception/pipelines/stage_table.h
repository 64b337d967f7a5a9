#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "perception/pipelines/estimate.h"

namespace cousin {

/// Hears a sentence for the user about input that is used in part or not at all.
using Warn = std::function<void(const std::string&)>;

/// A folder that holds a seam's files, kept as long as the result of this call.
using SeamFolder =
    std::function<std::shared_ptr<const std::filesystem::path>(const Capture&, const Estimate&)>;

/// A stage of any pipeline, and how its seam is kept in files.
struct StageRow {
  std::string_view name;
  /// Below a scene's folder, as patterns of a FolderClaim.
  std::vector<std::string_view> files;
  /// Stages that have nothing to do where this seam is known without them.
  std::vector<std::string_view> makes_needless;
  bool (*is_there)(const Stages&) = nullptr;
  void (*leave_out)(Stages&) = nullptr;
  /// Puts the stage of `from` in place of that of `base`.
  void (*replace)(Stages& base, const Stages& from) = nullptr;
  /// Puts the seam's files in its place. `warn` hears what a file holds that is not used.
  void (*read_from)(Stages&, SeamFolder, int scene_index, Warn warn) = nullptr;
  /// Runs the stage, which there must be, and keeps its result. @throws what the stage throws
  void (*run)(const Stages&, const Capture&, Estimate&) = nullptr;
  /// Null where the seam says nothing of each frame. @throws StageError where it does, and not of
  /// the capture's frames in their order
  void (*check)(std::string_view stage, const Capture&, const Estimate&) = nullptr;
  void (*write)(const std::filesystem::path& dir, const Estimate&, int scene_index) = nullptr;
};

/// To add a stage, add its member of SeamsOf, and a row.
std::span<const StageRow> stage_table();
/// @throws std::invalid_argument listing the names that exist.
const StageRow& stage_row(std::string_view name);

/// `base` with the named stages taken from `replacement`. @throws as stage_row
Stages replace_stages(Stages base, const Stages& replacement,
                      const std::vector<std::string>& names);

/// Leaves out what has nothing to do where the named seams are known.
void leave_out_needless(Stages& stages, const std::vector<std::string>& known);

/// Removes the files of a stage's seam from `dir`; there may be none. Where a command has claimed
/// the folder, only what it wrote there.
void remove_seam(const std::filesystem::path& dir, const StageRow& stage);

}  // namespace cousin
