// COLMAP's points [colmap.github.io/format.html]:
//   points3D.txt  POINT3D_ID X Y Z R G B ERROR TRACK[] (IMAGE_ID POINT2D_IDX)
//   points3D.bin  u64 count; each u64 id, f64 x y z, u8 r g b, f64 error, u64 track; each i32, i32
// Binary numbers are little-endian.

#include "sim/dataset/colmap_points.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "sim/dataset/text_fields.h"

namespace cousin {
namespace {

static_assert(std::endian::native == std::endian::little, "COLMAP's files are little-endian");

constexpr std::size_t kHeadBytes = 8 + 3 * 8 + 3 + 8 + 8;  ///< of a point, before its track
constexpr std::size_t kTrackBytes = 8;

template <class Number>
Number number_at(std::string_view bytes, std::size_t at) {
  std::array<char, sizeof(Number)> raw{};
  std::memcpy(raw.data(), bytes.data() + at, sizeof(Number));
  return std::bit_cast<Number>(raw);
}

}  // namespace

std::vector<ColmapStartPoint> colmap_points_from_text(std::string_view text,
                                                      const std::string& name) {
  std::vector<ColmapStartPoint> points;
  for (const TextLine& line : records(text, name)) {
    ColmapStartPoint point;
    for (std::size_t k = 0; k < 3; ++k) point.position[static_cast<int>(k)] = line.number(1 + k);
    point.color = {static_cast<std::uint8_t>(line.integer(4, 0, 255)),
                   static_cast<std::uint8_t>(line.integer(5, 0, 255)),
                   static_cast<std::uint8_t>(line.integer(6, 0, 255))};
    point.error_px = line.number(7);
    if (line.size() % 2 != 0) line.fail("its track has a number that has no pair");
    point.views = static_cast<int>((line.size() - 8) / 2);
    points.push_back(point);
  }
  return points;
}

std::vector<ColmapStartPoint> colmap_points_from_binary(std::string_view bytes,
                                                        const std::string& name) {
  std::size_t at = 0;
  const auto fail = [&](const std::string& what) {
    throw std::runtime_error(name + ": byte " + std::to_string(at) + ": " + what);
  };
  if (bytes.size() < 8) fail("the file ends before the count of points");
  const auto count = number_at<std::uint64_t>(bytes, at);
  at += 8;
  if (count > (bytes.size() - at) / kHeadBytes)
    fail("the file is too short for " + std::to_string(count) + " points");
  std::vector<ColmapStartPoint> points;
  points.reserve(static_cast<std::size_t>(count));
  for (std::uint64_t i = 0; i < count; ++i) {
    if (bytes.size() - at < kHeadBytes) fail("the file ends within point " + std::to_string(i));
    ColmapStartPoint point;
    for (int k = 0; k < 3; ++k) {
      point.position[k] = number_at<double>(bytes, at + 8 + 8 * static_cast<std::size_t>(k));
    }
    if (!point.position.allFinite()) fail("point " + std::to_string(i) + " is not finite");
    const std::size_t color = at + 32;
    point.color = {number_at<std::uint8_t>(bytes, color), number_at<std::uint8_t>(bytes, color + 1),
                   number_at<std::uint8_t>(bytes, color + 2)};
    point.error_px = number_at<double>(bytes, color + 3);
    if (!std::isfinite(point.error_px))
      fail("the error of point " + std::to_string(i) + " is not finite");
    const auto track = number_at<std::uint64_t>(bytes, color + 11);
    at += kHeadBytes;
    if (track > (bytes.size() - at) / kTrackBytes || track > std::numeric_limits<int>::max())
      fail("the file is too short for a track of " + std::to_string(track));
    at += static_cast<std::size_t>(track) * kTrackBytes;
    point.views = static_cast<int>(track);
    points.push_back(point);
  }
  return points;
}

}  // namespace cousin
