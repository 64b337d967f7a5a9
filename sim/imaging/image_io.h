#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sim/types/image.h"

namespace cousin {

/// PNG (libpng), JPEG (libjpeg-turbo), OpenEXR. Readers bound sizes (65535 a side, 2^28 pixels)
/// before they allocate;
/// @throws std::runtime_error naming the file and what is wrong (missing, truncated, another type).
/// A damaged or truncated JPEG is an error, not a picture with grey in it.
/// Writers make the folder, write beside, flush and rename; @throws std::runtime_error naming the
/// file, on a full disk too, and then nothing new is left; @throws std::invalid_argument if the
/// image is empty or above those limits.

/// PNG or JPEG by content, as stored: grey is spread, alpha dropped, 16 bits scaled to 8, EXIF
/// orientation not applied.
Image<Rgb8> read_color(const std::filesystem::path& file);
Image<std::uint8_t> read_png8(
    const std::filesystem::path& file);  ///< grey of at most 8 bits (fewer are scaled)
Image<std::uint16_t> read_png16(const std::filesystem::path& file);  ///< 16-bit grey only
/// An EXR picture is its display window: of a data window that is smaller, the rest is 0 (NaN where
/// one channel or vectors are read), of a larger one what lies outside is left away. Scan lines or
/// tiles, half or float; of several parts the one that has the channels. Refused: deep data,
/// subsampled and uint channels, a cube, a pixelAspectRatio other than 1, other chromaticities than
/// Rec. 709's.
Image<float> read_exr(const std::filesystem::path& file);  ///< channel "Z", or the only one
/// Channels of one EXR by their whole names ("R", "view.Depth.Z"), in that order; half floats are
/// widened.
std::vector<Image<float>> read_exr_channels(const std::filesystem::path& file,
                                            const std::vector<std::string>& channels);
Image<Rgbf> read_exr_color(const std::filesystem::path& file);  ///< channels R, G, B, or Y as grey
void write_png(const std::filesystem::path& file, const Image<Rgb8>& image);
void write_png(const std::filesystem::path& file, const Image<std::uint8_t>& image);
void write_png(const std::filesystem::path& file, const Image<std::uint16_t>& image);
void write_exr(const std::filesystem::path& file,
               const Image<float>& image);  ///< channel "Z", 32-bit float, ZIP

/// Baseline, 4:2:0, quality 1..100; the same bytes on every run.
std::vector<std::uint8_t> encode_jpeg(const Image<Rgb8>& image, int quality);
Image<Rgb8> decode_jpeg(const std::vector<std::uint8_t>& bytes);
std::vector<std::uint8_t> encode_png(const Image<Rgb8>& image);

}  // namespace cousin
