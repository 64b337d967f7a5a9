#pragma once

#include "scenes/row/scene_text.h"

namespace cousin {

inline constexpr SceneText kStrawberriesText = {
    .name = "strawberries",
    .help =
        "strawberries of three varieties on a raised bed, 1 to 10 fruits of all maturities "
        "in view, four lights (morning, overcast, noon, lamp), seen by a D457",
    .needs_physics = true};

}  // namespace cousin
