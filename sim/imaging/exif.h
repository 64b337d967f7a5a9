#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace cousin {

/// What the EXIF block of a JPEG file says of how the picture was taken [CIPA DC-008-2019, "Exif
/// 2.32"]. Nothing of it is applied: pixels are used as they are stored. Tags that are absent,
/// malformed or out of bounds are those of an empty block.
struct ExifTags {
  int orientation = 1;  ///< 1 to 8: how a viewer turns the picture; 1 = not at all
  std::optional<double> focal_length_mm;       ///< of the lens
  std::optional<double> focal_length_35mm_mm;  ///< on 36 x 24 mm film, with this angle of view
  std::optional<double> imager_pixels_per_mm;  ///< along x, for a picture of `width_px`
  /// Of the picture as it was taken; smaller copies keep these numbers.
  std::optional<int> width_px, height_px;
  std::string camera;  ///< maker and model, printable ASCII; may be empty
};

/// Of a JPEG file's bytes. Bytes of anything else hold no tags.
ExifTags exif_tags(std::span<const std::uint8_t> file_bytes);
/// @throws std::runtime_error naming the file if it cannot be read.
ExifTags read_exif(const std::filesystem::path& file);

/// What a viewer does for an orientation of 1 to 8: "turns it by 180 degrees". 1: "nothing".
std::string_view orientation_text(int orientation);

}  // namespace cousin
