#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sim/types/image.h"

namespace cousin {

/// Images of floats, as OpenEXR (image_io.h) or as NumPy's .npy (npy.h): the file's ending says
/// which.

/// `stem` ("depth/000000") with the one of `endings` that is below `dir`; empty if none is.
/// @throws std::runtime_error naming both where two are.
std::string float_file(const std::filesystem::path& dir, const std::string& stem,
                       const std::vector<std::string>& endings = {".exr", ".npy"});

/// @throws as the readers of image_io.h.
Image<float> read_floats(const std::filesystem::path& file);
Image<Eigen::Vector3f> read_float_vectors(const std::filesystem::path& file);
/// By the header alone. @throws std::runtime_error naming the file if it is damaged.
std::uint64_t float_pixels(const std::filesystem::path& file);

}  // namespace cousin
