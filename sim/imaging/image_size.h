#pragma once

#include <filesystem>

namespace cousin {

struct ImageSize {
  int width_px = 0;
  int height_px = 0;
};

/// Size of a PNG or JPEG file, as its head says; no pixel is decoded. @throws std::runtime_error
/// naming the file if it is neither, cut before its size, or of a size that no reader takes.
ImageSize read_image_size(const std::filesystem::path& file);

/// Whether a PNG has an alpha channel, which read_color drops.
bool has_alpha(const std::filesystem::path& file);

}  // namespace cousin
