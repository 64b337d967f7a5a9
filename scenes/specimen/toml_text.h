#pragma once

#include <string_view>

namespace cousin {

/// The scene's TOML file, compiled in so that the program needs no data folder.
std::string_view specimen_toml();

}  // namespace cousin
