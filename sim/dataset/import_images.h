#pragma once

#include <filesystem>
#include <vector>

#include "sim/types/capture.h"

namespace cousin {

/// Private to sim/dataset: the colour image of each frame's first sensor, of the size of its
/// camera. @throws std::runtime_error naming file, frame and both sizes.
void read_frame_colors(Capture& capture, const std::vector<std::filesystem::path>& images);

/// @throws std::runtime_error naming file, frame and both sizes unless they are equal.
void check_image_size(const std::filesystem::path& file, int frame, int width_px, int height_px,
                      const Camera& camera);

}  // namespace cousin
