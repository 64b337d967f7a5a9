#pragma once

#include <string_view>

namespace cousin {

/// The scene's TOML files, compiled in so that the program needs no data folder.
std::string_view varieties_toml();
std::string_view truss_toml();
std::string_view strawberry_plant_toml();
std::string_view strawberry_bed_toml();
std::string_view strawberry_cousins_toml();

}  // namespace cousin
