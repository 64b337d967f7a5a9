#pragma once

#include <string_view>

namespace cousin {

/// The scene's TOML files, compiled in so that the program needs no data folder.
std::string_view watermelon_toml();
std::string_view tray_toml();
std::string_view seedling_cousins_toml();

}  // namespace cousin
