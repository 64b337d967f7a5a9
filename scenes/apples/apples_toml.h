#pragma once

#include <string_view>

namespace cousin {

/// The scene's TOML files, compiled in so that the program needs no data folder.
std::string_view apples_toml();  ///< cultivars.toml
std::string_view orchard_toml();
std::string_view apple_cousins_toml();

}  // namespace cousin
