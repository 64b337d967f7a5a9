#pragma once

#include <string_view>

namespace cousin {

/// Which light each pixel of an image of single photosites measures: all of it, or one colour of a
/// Bayer pattern named by its pixels (0, 0) (1, 0) (0, 1) (1, 1).
enum class Mosaic { grey, rggb, bggr, grbg, gbrg };

std::string_view to_string(Mosaic mosaic);
/// @throws std::invalid_argument naming the text and the names that exist.
Mosaic mosaic_from_string(std::string_view text);

/// Channel of a pixel of a Bayer pattern: 0 red, 1 green, 2 blue; x, y >= 0.
int bayer_channel(Mosaic mosaic, int x, int y);

/// What the numbers of a linear 16-bit image mean: light is (code - black_level) over
/// (2^bits - 1 - black_level) of saturation.
struct RawFormat {
  Mosaic mosaic = Mosaic::grey;
  int bits = 16;        ///< 1..16
  int black_level = 0;  ///< code without light, below 2^bits - 1
  bool operator==(const RawFormat&) const = default;
};
/// @throws std::invalid_argument naming field, value and limit.
void validate(const RawFormat& format);

}  // namespace cousin
