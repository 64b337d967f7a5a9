#pragma once

#include <span>

#include "sim/sensors/phone_presets.h"

namespace cousin {

/// The depth cameras' files of presets/, compiled in at configure time.
std::span<const PresetText> active_stereo_preset_texts();

}  // namespace cousin
