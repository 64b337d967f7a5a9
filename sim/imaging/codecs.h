#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sim/types/image.h"

namespace cousin::imaging {

/// Private to sim/imaging: decoders of bytes in memory. `name` begins every message.
/// All throw std::runtime_error; sizes are bounded before pixels are allocated.
bool is_png(std::span<const std::uint8_t> bytes);
bool is_jpeg(std::span<const std::uint8_t> bytes);

Image<Rgb8> decode_png_color(std::span<const std::uint8_t> bytes, const std::string& name);
Image<std::uint8_t> decode_png8(std::span<const std::uint8_t> bytes, const std::string& name);
Image<std::uint16_t> decode_png16(std::span<const std::uint8_t> bytes, const std::string& name);
std::vector<std::uint8_t> encode_png_pixels(const Image<Rgb8>& image);
std::vector<std::uint8_t> encode_png_pixels(const Image<std::uint8_t>& image);
std::vector<std::uint8_t> encode_png_pixels(const Image<std::uint16_t>& image);

Image<Rgb8> decode_jpeg(std::span<const std::uint8_t> bytes, const std::string& name);

/// Channels by their whole names: those of the first choice that the file has; an empty choice is
/// its only channel, whatever that is called. The picture is the display window; `fill` is where it
/// has no data.
std::vector<Image<float>> decode_exr(std::span<const std::uint8_t> bytes, const std::string& name,
                                     const std::vector<std::vector<std::string>>& choices,
                                     float fill);
std::vector<std::uint8_t> encode_exr(const Image<float>& image);
std::vector<std::uint8_t> encode_exr(const Image<Rgbf>& image);
std::vector<std::uint8_t> encode_exr(const Image<Eigen::Vector3f>& image);

/// @throws std::invalid_argument if there are no pixels, or more than a reader accepts.
void check_encodable(int width, int height);

}  // namespace cousin::imaging
