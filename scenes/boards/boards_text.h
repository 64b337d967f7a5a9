#pragma once

#include "scenes/row/scene_text.h"

namespace cousin {

inline constexpr SceneText kBoardsText = {
    .name = "boards",
    .help =
        "calibration boards (chessboards, ChArUco, AprilGrid, circles) with warp, stretch "
        "and gloss, on a table, on a stand or held by hand",
    .has_points = true};

}  // namespace cousin
