#include "sim/imaging/image_size.h"

#include <cstdint>
#include <stdexcept>
#include <vector>

#include "sim/imaging/codecs.h"
#include "sim/imaging/file_bytes.h"
#include "sim/imaging/jpeg_segments.h"

namespace cousin {
namespace {

using Bytes = std::span<const std::uint8_t>;

std::uint32_t big_endian(Bytes bytes, std::size_t at, std::size_t size) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < size; ++i) value = value << 8 | bytes[at + i];
  return value;
}

ImageSize checked(const std::filesystem::path& file, std::uint32_t width, std::uint32_t height) {
  imaging::check_image_size(file.string(), width, height);
  return {static_cast<int>(width), static_cast<int>(height)};
}

/// A frame header, of any of JPEG's processes: FF C0 to FF CF but tables and what is reserved.
bool is_frame_header(std::uint8_t marker) {
  return marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
}

}  // namespace

ImageSize read_image_size(const std::filesystem::path& file) {
  const std::vector<std::uint8_t> bytes = imaging::read_bytes(file);
  if (imaging::is_png(bytes)) {
    // The first chunk, IHDR, follows the signature of 8 bytes, its length and name.
    if (bytes.size() < 24) throw std::runtime_error(file.string() + ": PNG: truncated");
    return checked(file, big_endian(bytes, 16, 4), big_endian(bytes, 20, 4));
  }
  if (!imaging::is_jpeg(bytes))
    throw std::runtime_error(file.string() + ": neither a PNG nor a JPEG file");
  for (const imaging::JpegSegment& segment : imaging::jpeg_segments(bytes)) {
    if (is_frame_header(segment.marker) && segment.body.size() >= 5)
      return checked(file, big_endian(segment.body, 3, 2), big_endian(segment.body, 1, 2));
  }
  throw std::runtime_error(file.string() + ": JPEG: truncated before its size");
}

bool has_alpha(const std::filesystem::path& file) {
  const std::vector<std::uint8_t> bytes = imaging::read_bytes(file);
  return imaging::is_png(bytes) && bytes.size() > 25 && (bytes[25] == 4 || bytes[25] == 6);
}

}  // namespace cousin
