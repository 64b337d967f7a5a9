#pragma once

#include <span>

#include "sim/sensors/preset_text.h"

namespace cousin {

/// The files of presets/ for time of flight and structured light, compiled in at configure time.
std::span<const PresetText> time_of_flight_preset_texts();
std::span<const PresetText> structured_light_preset_texts();

}  // namespace cousin
