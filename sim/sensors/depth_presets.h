#pragma once

#include <span>
#include <string>
#include <vector>

#include "sim/sensors/preset_text.h"

namespace cousin {

/// The files of presets/ for time of flight and structured light, compiled in at configure time.
std::span<const PresetText> time_of_flight_preset_texts();
std::span<const PresetText> structured_light_preset_texts();

std::vector<std::string> preset_names(std::span<const PresetText> presets);
/// @throws std::invalid_argument listing the names that exist.
std::string_view preset_toml(std::span<const PresetText> presets, const std::string& name);

}  // namespace cousin
