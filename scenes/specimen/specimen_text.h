#pragma once

#include "scenes/row/scene_text.h"

namespace cousin {

inline constexpr SceneText kSpecimenText = {
    .name = "specimen",
    .help = "your own mesh on a table: --set mesh=FILE (PLY, OBJ, STL, glTF) --set unit=mm"};

}  // namespace cousin
