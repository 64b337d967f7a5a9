#pragma once

#include <Eigen/Core>
#include <filesystem>

#include "sim/types/image.h"

namespace cousin {

/// Private to sim/dataset: three-channel OpenEXR ("X", "Y", "Z", 32-bit float, ZIP); bits survive,
/// NaN too.
void write_exr_vectors(const std::filesystem::path& file, const Image<Eigen::Vector3f>& image);
/// @throws std::runtime_error naming the file: missing, truncated, other channels, above 65535 a
/// side or 2^28 pixels.
Image<Eigen::Vector3f> read_exr_vectors(const std::filesystem::path& file);

}  // namespace cousin
