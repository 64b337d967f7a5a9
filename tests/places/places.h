#pragma once

#include <filesystem>

namespace cousin {

/// The root of this checkout, for tests that read its scenes, presets and pictures.
std::filesystem::path source_folder();

/// Where real captures lie (the CMake entry COUSIN_REAL_DATA); it may be absent: tests that need it
/// skip.
std::filesystem::path real_data();

}  // namespace cousin
