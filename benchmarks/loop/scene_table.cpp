#include "benchmarks/loop/scene_table.h"

#include <stdexcept>

#include "scenes/seeds/seeds_scene.h"

namespace cousin {

std::span<const SceneEntry> scene_table() {
  static const std::vector<SceneEntry> kScenes = [] {
    std::vector<SceneEntry> scenes = part_scenes();
    scenes.insert(scenes.begin(),
                  {.text = seeds_row().text,
                   .status = COUSIN_WITH_MUJOCO ? "built in" : "not built in: WITH_MUJOCO is OFF",
                   .row = &seeds_row()});
    return scenes;
  }();
  return kScenes;
}

const SceneEntry& scene_entry(const std::string& name) {
  std::string names;
  for (const SceneEntry& entry : scene_table()) {
    if (entry.text.name == name) return entry;
    names += (names.empty() ? "" : ", ") + entry.name();
  }
  throw std::invalid_argument("scene \"" + name + "\" is not one of: " + names);
}

const SceneRow& built_row(const SceneEntry& entry) {
  if (!entry.row) throw std::invalid_argument("scene \"" + entry.name() + "\" is " + entry.status);
  return *entry.row;
}

}  // namespace cousin
