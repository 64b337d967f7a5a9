#include "sim/imaging/jpeg_segments.h"

#include "sim/imaging/codecs.h"

namespace cousin::imaging {

std::vector<JpegSegment> jpeg_segments(std::span<const std::uint8_t> file) {
  std::vector<JpegSegment> segments;
  if (!is_jpeg(file)) return segments;
  constexpr std::uint8_t kStartOfScan = 0xDA, kEnd = 0xD9;
  std::size_t at = 2;
  while (at + 4 <= file.size() && file[at] == 0xFF) {
    const std::uint8_t marker = file[at + 1];
    if (marker == 0xFF) {  // a fill byte
      ++at;
      continue;
    }
    if (marker == kStartOfScan || marker == kEnd) break;
    const std::size_t length = std::size_t{file[at + 2]} << 8 | file[at + 3];
    if (length < 2 || length > file.size() - at - 2) break;
    segments.push_back({marker, file.subspan(at + 4, length - 2)});
    at += 2 + length;
  }
  return segments;
}

}  // namespace cousin::imaging
