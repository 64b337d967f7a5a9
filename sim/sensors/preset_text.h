#pragma once

#include <span>
#include <string>
#include <string_view>

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

}  // namespace cousin
