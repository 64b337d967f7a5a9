#pragma once

#include <string_view>

namespace cousin {

/// A file of presets/, compiled in.
struct PresetText {
  std::string_view name;
  std::string_view toml;
};

}  // namespace cousin
