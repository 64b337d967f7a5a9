#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "perception/pipelines/seeds.h"

namespace cousin {

/// One `--stage NAME=dir:PATH` or `--stage NAME=exec:PROGRAM`.
struct StageSource {
  enum class Kind { directory, program };
  std::string stage;
  Kind kind = Kind::directory;
  std::filesystem::path path;
  double time_limit_s = 21600;  ///< of one call of the program, six hours; it is ended then
};
/// @throws std::invalid_argument naming the text, the forms and the stages that exist, or the
/// folder or program that does not.
StageSource parse_stage_source(const std::string& text, double time_limit_s = 21600);

/// Whether one of them stands in place of the stage.
bool replaces(const std::vector<StageSource>& sources, std::string_view stage);
std::string to_text(const StageSource& source);  ///< "exec:./mine"

/// Hears a sentence for the user about input that is used in part or not at all.
using Warn = std::function<void(const std::string&)>;

/// Whether a stage failed for what a user gave or for the disk, and not inside a program: its files
/// are a folder's (`dir:`), or the input of its program could not be written.
/// @param stages  as on the command line; of two for one stage the last counts.
bool is_fault_of_input(const StageError& error, const std::vector<std::string>& stages);

/// `base` with each named stage read from files or made by a program. `dir:PATH` reads the seam's
/// file of PATH/SCENE_ID or PATH. `exec:PROGRAM` is called as PROGRAM INPUT_DIR OUTPUT_DIR;
/// INPUT_DIR holds the capture and the earlier seams, never truth. Missing or malformed files, a
/// non-zero exit and one that does not come in time throw std::runtime_error. Masks must be of the
/// scene's images. `warn` hears what a file held that is not used.
SeedsStages with_stage_sources(SeedsStages base, const std::vector<StageSource>& sources,
                               int scene_index, const Warn& warn = {});

/// Writes the seam of one finished stage into `dir`; stages without a file of their own write
/// nothing.
void write_seam(const std::filesystem::path& dir, const std::string& stage,
                const SeedsEstimate& estimate, int scene_index);

/// Files that perceive_seeds and perceive_views write into a scene's folder: names for a
/// FolderClaim, below `scene`.
std::vector<std::string> estimate_names(const std::filesystem::path& scene);

/// Removes the files of a stage's seam from `dir`; there may be none. Where a command has claimed
/// the folder, only what it wrote there.
void remove_seam(const std::filesystem::path& dir, const std::string& stage);

/// "000003" for 3.
std::string scene_id(int scene_index);

}  // namespace cousin
