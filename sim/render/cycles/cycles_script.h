#pragma once

#include <string_view>

namespace cousin {

/// scripts/cycles_render.py, compiled in so that the program needs no data path.
extern const std::string_view kCyclesScript;

}  // namespace cousin
