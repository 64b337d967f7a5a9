#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace cousin::imaging {

/// Private to sim/imaging: a segment of a JPEG file before its picture's data.
struct JpegSegment {
  std::uint8_t marker = 0;             ///< 0xE1 of FF E1
  std::span<const std::uint8_t> body;  ///< after the two bytes of its length
};

/// Those up to the first scan, in the file's order; they point into `file`. A file that is cut or
/// malformed gives those before; one that is no JPEG gives none.
std::vector<JpegSegment> jpeg_segments(std::span<const std::uint8_t> file);

}  // namespace cousin::imaging
