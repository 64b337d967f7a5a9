#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "perception/pipelines/stage_table.h"

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

/// Stages that a pipeline has not would be read and never used.
/// @throws std::invalid_argument naming the stage, the pipeline and what it has
void check_stages(const std::vector<StageSource>& sources, StageOrder order,
                  std::string_view pipeline);

/// Whether one of them stands in place of the stage.
bool replaces(const std::vector<StageSource>& sources, std::string_view stage);
std::string to_text(const StageSource& source);  ///< "exec:./mine"

/// Whether a stage failed for what a user gave or for the disk, and not inside a program: its files
/// are a folder's (`dir:`), or the input of its program could not be written.
/// @param stages  as on the command line; of two for one stage the last counts.
bool is_fault_of_input(const StageError& error, const std::vector<std::string>& stages);

/// `base` with each named stage read from files or made by a program. `dir:PATH` reads the seam's
/// file of PATH/SCENE_ID or PATH. `exec:PROGRAM` is called as PROGRAM INPUT_DIR OUTPUT_DIR;
/// INPUT_DIR holds the capture and the earlier seams, never truth. Missing or malformed files, a
/// non-zero exit and one that does not come in time throw std::runtime_error. Masks must be of the
/// scene's images. `warn` hears what a file held that is not used.
/// @param order  of the pipeline: which seams are earlier
Stages with_stage_sources(Stages base, const std::vector<StageSource>& sources, StageOrder order,
                          int scene_index, const Warn& warn = {});

/// Files that `perceive` and perceive_views write into a scene's folder: names for a
/// FolderClaim, below `scene`.
std::vector<std::string> estimate_names(const std::filesystem::path& scene);

/// "000003" for 3.
std::string scene_id(int scene_index);

}  // namespace cousin
