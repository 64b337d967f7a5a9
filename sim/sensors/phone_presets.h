#pragma once

#include <span>
#include <string_view>

namespace cousin {

struct PresetText {
  std::string_view name;
  std::string_view toml;
};

/// The files of presets/, compiled in at configure time so that the program needs no data path.
std::span<const PresetText> phone_preset_texts();

}  // namespace cousin
