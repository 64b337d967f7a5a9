#pragma once

#include <filesystem>

#include "sim/types/image.h"

namespace cousin {

/// Channels R, G, B of 32-bit float, ZIP: what read_exr_color (image_io.h) gives back bit by bit.
/// @throws as the writers of image_io.h.
void write_exr_color(const std::filesystem::path& file, const Image<Rgbf>& image);

}  // namespace cousin
