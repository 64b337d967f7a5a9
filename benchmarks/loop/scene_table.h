#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "benchmarks/loop/run_config.h"

namespace cousin {

/// A row of `cousin scenes`.
struct SceneEntry {
  SceneText text;
  std::string status;             ///< "built in", or why not
  const SceneRow* row = nullptr;  ///< null: not in this part of the program
  std::string name() const { return std::string(text.name); }
};

/// All scenes: seeds, then those of scene_list.h.
std::span<const SceneEntry> scene_table();
/// @throws std::invalid_argument listing the names that exist.
const SceneEntry& scene_entry(const std::string& name);
/// What makes the scene. @throws std::invalid_argument if it is not in this part of the program
const SceneRow& built_row(const SceneEntry& entry);

/// One entry for each of scene_list.h. In the part `scenes` they are `part_scenes.cpp`'s; in the
/// first part `benchmarks/app/part_scenes_off.cpp`'s, which say how to build the other.
std::vector<SceneEntry> part_scenes();

}  // namespace cousin
