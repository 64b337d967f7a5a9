#pragma once

#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "sim/config/fields.h"

namespace cousin {

/// A file of presets/, compiled in.
struct PresetText {
  std::string_view name;
  std::string_view toml;
};

/// Whether a rig's name is the path of a file of one's own: it ends with ".toml".
bool is_preset_file(std::string_view name);

/// The TOML of one of `presets` by its name, or that of a file whose path is given in its place.
/// @throws std::invalid_argument listing the names if there is none; std::runtime_error naming a
/// file that cannot be read or has more than 1 MiB.
std::string preset_toml(const std::string& name, std::span<const PresetText> presets);
/// What messages call it: the path of a file, else "name.toml".
std::string preset_title(const std::string& name);
std::vector<std::string> preset_names(std::span<const PresetText> presets);

/// A preset by its name, or of a file by its path, checked.
/// @throws what preset_toml does; std::runtime_error naming preset, key, value and limit.
template <class Config>
Config read_preset(const std::string& name, std::span<const PresetText> presets) {
  Config config;
  read_toml_text(preset_toml(name, presets), preset_title(name), fields(config),
                 MissingKeys::error);
  try {
    validate(config);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(preset_title(name) + ": " + error.what());
  }
  return config;
}

}  // namespace cousin
