#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "sim/types/image.h"

namespace cousin {

/// How truth images of floats are written. `npy` and `exr` keep every bit. `png16` is of depths:
/// 16-bit PNG in steps, 0 = none, and beside it 000000.json: {"depth_scale": millimetres a step}.
/// The step is the least of 0.1, 1, 10, 100 and 1000 mm in which the image's largest depth is at
/// most 65535; a depth becomes the nearest step, from 1 on. Other images are then .npy.
enum class TruthFormat { npy, exr, png16 };

std::string to_string(TruthFormat format);
/// @throws std::invalid_argument naming the text and the formats.
TruthFormat truth_format_from_string(std::string_view text);

/// Files of the depth image `stem` ("depth/000000") in a format.
std::vector<std::string> depth_files(const std::string& stem, TruthFormat format);

/// `dir`/`stem` with the format's ending, folders made.
/// @throws as the writers of image_io.h, and std::invalid_argument naming file and depth where a
/// depth is negative, infinite or above 65535 m and the format is png16.
void write_truth_depth(const std::filesystem::path& dir, const std::string& stem,
                       const Image<float>& depth_m, TruthFormat format);
void write_truth_floats(const std::filesystem::path& dir, const std::string& stem,
                        const Image<float>& image, TruthFormat format);
void write_truth_vectors(const std::filesystem::path& dir, const std::string& stem,
                         const Image<Eigen::Vector3f>& image, TruthFormat format);

/// Endings that an image of depths, or another one, may have.
std::vector<std::string> depth_endings();
/// Of any of these endings, metres, NaN = none. @param relative  as float_file (float_files.h)
/// gives it. @throws as read_floats; std::runtime_error if the PNG's scale is missing or not in (0,
/// 1000].
Image<float> read_truth_depth(const std::filesystem::path& dir, const std::string& relative);

}  // namespace cousin
