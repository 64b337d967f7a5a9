#pragma once

#include <cstdint>
#include <filesystem>

namespace cousin {

/// Pixels that an EXR's channels have, from its header alone: what reading it would take is known
/// before any of it is taken.
/// @throws std::runtime_error naming the file if it is no EXR or its window is not an image's.
std::uint64_t exr_pixels(const std::filesystem::path& file);

}  // namespace cousin
