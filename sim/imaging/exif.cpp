// The EXIF block of a JPEG file: a segment FF E1 that starts with "Exif\0\0", then a TIFF file:
//   "II" or "MM" (byte order), 42, offset of the first directory
//   directory: u16 count; each 12 bytes: u16 tag, u16 type, u32 count, value or its offset
// Tags are read from the first directory and from the one that its tag 8769 points to. No other
// directory is followed, so that no file can make a loop.

#include "sim/imaging/exif.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "sim/imaging/file_bytes.h"
#include "sim/imaging/jpeg_segments.h"

namespace cousin {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::uint16_t kMake = 0x010F, kModel = 0x0110, kOrientation = 0x0112,
                        kExifDirectory = 0x8769, kFocalLength = 0x920A, kPixelWidth = 0xA002,
                        kPixelHeight = 0xA003, kImagerPixels = 0xA20E, kImagerUnit = 0xA210,
                        kFocalLength35mm = 0xA405;
constexpr std::uint16_t kAscii = 2, kShort = 3, kLong = 4, kRational = 5;
constexpr std::size_t kEntryBytes = 12;

class TiffBlock {
 public:
  explicit TiffBlock(Bytes bytes) : bytes_(bytes) {
    if (bytes.size() < 8 || bytes[0] != bytes[1]) return;
    is_big_endian_ = bytes[0] == 'M';
    is_valid_ = (is_big_endian_ || bytes[0] == 'I') && u16(2) == 42;
  }
  bool is_valid() const { return is_valid_; }
  /// 0 beyond the end, so that a cut block reads as one without the tag.
  std::uint32_t u16(std::size_t at) const { return number(at, 2); }
  std::uint32_t u32(std::size_t at) const { return number(at, 4); }
  Bytes part(std::size_t at, std::size_t size) const {
    return at <= bytes_.size() && size <= bytes_.size() - at ? bytes_.subspan(at, size) : Bytes();
  }

 private:
  std::uint32_t number(std::size_t at, std::size_t size) const {
    std::uint32_t value = 0;
    const Bytes raw = part(at, size);
    for (std::size_t i = 0; i < raw.size(); ++i)
      value = value << 8 | raw[is_big_endian_ ? i : raw.size() - 1 - i];
    return value;
  }
  Bytes bytes_;
  bool is_big_endian_ = false;
  bool is_valid_ = false;
};

class Directory {
 public:
  Directory(const TiffBlock& tiff, std::uint32_t offset) : tiff_(&tiff), offset_(offset) {
    if (!tiff.part(offset, 2).empty()) count_ = tiff.u16(offset);
  }

  /// A whole number or a ratio that is finite and above 0.
  std::optional<double> number(std::uint16_t tag) const {
    const std::optional<std::size_t> at = entry(tag);
    if (!at) return std::nullopt;
    double value = 0;
    switch (tiff_->u16(*at + 2)) {
      case kShort:
        value = tiff_->u16(*at + 8);
        break;
      case kLong:
        value = tiff_->u32(*at + 8);
        break;
      case kRational: {
        const std::uint32_t offset = tiff_->u32(*at + 8);
        if (tiff_->part(offset, 8).empty()) return std::nullopt;
        value = static_cast<double>(tiff_->u32(offset)) / tiff_->u32(std::size_t{offset} + 4);
        break;
      }
      default:
        return std::nullopt;
    }
    if (!std::isfinite(value) || !(value > 0)) return std::nullopt;
    return value;
  }

  /// Its printable characters, at most 64, without blanks at the ends.
  std::string text(std::uint16_t tag) const {
    const std::optional<std::size_t> at = entry(tag);
    if (!at || tiff_->u16(*at + 2) != kAscii) return {};
    const std::uint32_t count = tiff_->u32(*at + 4);
    std::string result;
    for (const std::uint8_t c : tiff_->part(count <= 4 ? *at + 8 : tiff_->u32(*at + 8), count)) {
      if (c == 0 || result.size() == 64) break;
      if (c >= 32 && c < 127) result += static_cast<char>(c);
    }
    const std::size_t first = result.find_first_not_of(' ');
    if (first == std::string::npos) return {};
    return result.substr(first, result.find_last_not_of(' ') - first + 1);
  }

 private:
  std::optional<std::size_t> entry(std::uint16_t tag) const {
    for (std::size_t i = 0; i < count_; ++i) {
      const std::size_t at = std::size_t{offset_} + 2 + i * kEntryBytes;
      if (tiff_->part(at, kEntryBytes).empty()) return std::nullopt;
      if (tiff_->u16(at) == tag) return at;
    }
    return std::nullopt;
  }
  const TiffBlock* tiff_;
  std::uint32_t offset_;
  std::size_t count_ = 0;
};

/// The TIFF file within the EXIF segment; empty where there is none.
Bytes exif_block(Bytes file) {
  constexpr std::array<std::uint8_t, 6> kName = {'E', 'x', 'i', 'f', 0, 0};
  for (const imaging::JpegSegment& segment : imaging::jpeg_segments(file)) {
    if (segment.marker != 0xE1 || segment.body.size() < kName.size()) continue;
    if (std::equal(kName.begin(), kName.end(), segment.body.begin()))
      return segment.body.subspan(kName.size());
  }
  return {};
}

/// Side of a picture, if it is one.
std::optional<int> side_px(const std::optional<double>& value) {
  if (!value || *value > 65535) return std::nullopt;
  return static_cast<int>(*value);
}

/// FocalPlaneXResolution counts pixels in the unit that another tag names.
std::optional<double> pixels_per_mm(const Directory& exif) {
  const std::optional<double> per_unit = exif.number(kImagerPixels);
  const double unit = exif.number(kImagerUnit).value_or(2);
  constexpr std::array<double, 4> kMillimetres = {25.4, 10, 1, 0.001};  ///< of units 2 to 5
  for (std::size_t i = 0; per_unit && i < kMillimetres.size(); ++i) {
    if (unit == static_cast<double>(i + 2)) return *per_unit / kMillimetres[i];
  }
  return std::nullopt;
}

}  // namespace

ExifTags exif_tags(std::span<const std::uint8_t> file_bytes) {
  ExifTags tags;
  const TiffBlock tiff(exif_block(file_bytes));
  if (!tiff.is_valid()) return tags;
  const Directory first(tiff, tiff.u32(4));
  const double orientation = first.number(kOrientation).value_or(1);
  if (orientation >= 1 && orientation <= 8) tags.orientation = static_cast<int>(orientation);
  const std::string make = first.text(kMake), model = first.text(kModel);
  tags.camera = make.empty() || model.starts_with(make) ? model : make + " " + model;
  const std::optional<double> offset = first.number(kExifDirectory);
  if (!offset || *offset > 4294967295.0) return tags;
  const Directory exif(tiff, static_cast<std::uint32_t>(*offset));
  tags.focal_length_mm = exif.number(kFocalLength);
  tags.focal_length_35mm_mm = exif.number(kFocalLength35mm);
  tags.imager_pixels_per_mm = pixels_per_mm(exif);
  tags.width_px = side_px(exif.number(kPixelWidth));
  tags.height_px = side_px(exif.number(kPixelHeight));
  return tags;
}

ExifTags read_exif(const std::filesystem::path& file) {
  return exif_tags(imaging::read_bytes(file));
}

std::string_view orientation_text(int orientation) {
  constexpr std::array<std::string_view, 9> kTexts = {
      "nothing",
      "nothing",
      "mirrors it left to right",
      "turns it by 180 degrees",
      "mirrors it top to bottom",
      "mirrors it left to right and turns it by 90 degrees anticlockwise",
      "turns it by 90 degrees clockwise",
      "mirrors it left to right and turns it by 90 degrees clockwise",
      "turns it by 90 degrees anticlockwise"};
  return orientation >= 1 && orientation <= 8 ? kTexts[static_cast<std::size_t>(orientation)]
                                              : kTexts[0];
}

}  // namespace cousin
