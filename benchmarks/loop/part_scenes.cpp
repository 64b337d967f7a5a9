#include "benchmarks/loop/scene_list.h"
#include "benchmarks/loop/scene_table.h"

namespace cousin {

#define COUSIN_DECLARE(text, row) const SceneRow& row();
COUSIN_PART_SCENES(COUSIN_DECLARE)
#undef COUSIN_DECLARE

std::vector<SceneEntry> part_scenes() {
  std::vector<SceneEntry> scenes;
#define COUSIN_ADD(own_text, own_row) scenes.push_back({.text = own_text, .row = &own_row()});
  COUSIN_PART_SCENES(COUSIN_ADD)
#undef COUSIN_ADD
  for (SceneEntry& scene : scenes) {
    const bool is_built = COUSIN_WITH_MUJOCO || !scene.text.needs_physics;
    scene.status = is_built ? "built in" : "not built in: WITH_MUJOCO is OFF";
  }
  return scenes;
}

}  // namespace cousin
