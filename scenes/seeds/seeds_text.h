#pragma once

#include "scenes/row/scene_text.h"

namespace cousin {

inline constexpr SceneText kSeedsText = {
    .name = "seeds",
    .help =
        "ten seeds dropped on a calibration board before a green screen, three camera rings "
        "(zhengdan958, tianguinuo932, jimai22, aikang58, suijing18, xiangyaxiangzhan)",
    .needs_physics = true};

}  // namespace cousin
