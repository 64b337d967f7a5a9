#pragma once

#include "scenes/row/scene_text.h"

namespace cousin {

inline constexpr SceneText kApplesText = {
    .name = "apples",
    .help =
        "a Fuji spindle tree in its row, seen from 0.1 to 1 m of a fruit; four lights "
        "(front, back, side, shade); occlusion on demand"};

}  // namespace cousin
