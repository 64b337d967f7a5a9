#pragma once

#include "scenes/row/scene_text.h"

namespace cousin {

inline constexpr SceneText kSeedlingsText = {
    .name = "seedlings",
    .help =
        "watermelon seedlings of day 0 to 12 in a tray of 50 cells, hand-held views, three "
        "lights (D1 sun, D2 overcast, D3 violet LED)"};

}  // namespace cousin
