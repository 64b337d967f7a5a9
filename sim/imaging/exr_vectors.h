#pragma once

#include <Eigen/Core>
#include <filesystem>

#include "sim/types/image.h"

namespace cousin {

/// Channels X, Y, Z of 32-bit float, ZIP: bits survive, NaN too.
/// @throws as the writers of image_io.h.
void write_exr_vectors(const std::filesystem::path& file, const Image<Eigen::Vector3f>& image);
/// Half floats are widened. @throws as read_exr_channels (image_io.h).
Image<Eigen::Vector3f> read_exr_vectors(const std::filesystem::path& file);

}  // namespace cousin
