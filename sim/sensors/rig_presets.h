#pragma once

#include <span>

#include "sim/sensors/preset_text.h"

namespace cousin {

/// The rigs of presets/, compiled in at configure time so that the program needs no data path.
std::span<const PresetText> rig_preset_texts();

}  // namespace cousin
