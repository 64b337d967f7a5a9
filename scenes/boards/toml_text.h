#pragma once

#include <string_view>

namespace cousin {

/// The scene's TOML files, compiled in so that the program needs no data folder.
std::string_view boards_toml();
std::string_view board_presets_toml();
std::string_view board_cousins_toml();

}  // namespace cousin
