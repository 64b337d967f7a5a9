#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "sim/types/image.h"

namespace cousin {

/// NumPy's .npy files of 32-bit floats, little endian, in C order [NEP 1]: numpy.load gives an
/// array of (height, width), or of (height, width, 3) for vectors. Bits survive, NaN too. Readers
/// take versions 1 to 3 and nothing but such an array.
/// @throws as the readers and writers of image_io.h.
void write_npy(const std::filesystem::path& file, const Image<float>& image);
void write_npy(const std::filesystem::path& file, const Image<Eigen::Vector3f>& image);
Image<float> read_npy(const std::filesystem::path& file);
Image<Eigen::Vector3f> read_npy_vectors(const std::filesystem::path& file);

/// Pixels by the header alone: what reading would take is known before any of it is taken.
/// @throws std::runtime_error naming the file if its header is not an image's.
std::uint64_t npy_pixels(const std::filesystem::path& file);

namespace imaging {

/// Private to sim/imaging: bytes in memory. `name` begins every message.
/// @throws std::runtime_error; sizes are bounded before pixels are allocated.
Image<float> decode_npy(std::span<const std::uint8_t> bytes, const std::string& name);
Image<Eigen::Vector3f> decode_npy_vectors(std::span<const std::uint8_t> bytes,
                                          const std::string& name);

}  // namespace imaging
}  // namespace cousin
