#include "benchmarks/app/parts.h"
#include "benchmarks/loop/scene_list.h"
#include "benchmarks/loop/scene_table.h"

namespace cousin {

std::vector<SceneEntry> part_scenes() {
  const std::string how = how_to_build(kScenesPart.name);
  return {
#define COUSIN_ADD(own_text, own_row) {.text = own_text, .status = how},
      COUSIN_PART_SCENES(COUSIN_ADD)
#undef COUSIN_ADD
  };
}

}  // namespace cousin
