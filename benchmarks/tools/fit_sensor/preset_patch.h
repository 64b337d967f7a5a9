#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace cousin {

/// A key of a preset and what replaces its value.
struct PresetPatch {
  std::string key;      ///< dotted: "model.spatial_px"
  std::string value;    ///< as TOML
  std::string comment;  ///< one line, without "# "
};

/// A preset's TOML with values replaced, everything else as it was. Each replaced key has a comment
/// of its own; keys that follow it without a comment get again the one that was theirs.
/// @throws std::invalid_argument naming a key that the text lacks.
std::string patched_preset(std::string_view toml, const std::vector<PresetPatch>& patches);

/// Whether the text gives the dotted key a value.
bool has_key(std::string_view toml, std::string_view key);

}  // namespace cousin
