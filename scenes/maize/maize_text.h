#pragma once

#include "scenes/row/scene_text.h"

namespace cousin {

inline constexpr SceneText kMaizeText = {
    .name = "maize",
    .help =
        "maize from V3 to VT, one plant or rows, with a keypoint at every node, seen by a "
        "ZED stereo camera"};

}  // namespace cousin
