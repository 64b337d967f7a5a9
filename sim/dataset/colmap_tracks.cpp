// Points of COLMAP's sparse model [colmap.github.io/format.html], after what colmap_model.cpp
// reads:
//   images.bin    of each image, after its name: u64 points; each f64 x, y, u64 point
//   points3D.bin  u64 count; each u64 id, f64 x y z, u8 r g b, f64 error, u64 sightings; each i32
//                 image, i32 index of the image's point
// Binary numbers are little-endian; pixels count from the image's corner.

#include "sim/dataset/colmap_tracks.h"

#include <cmath>
#include <cstdint>
#include <map>
#include <stdexcept>

#include "sim/dataset/byte_reader.h"

namespace cousin {
namespace {

using Pixels = std::map<int, std::vector<Eigen::Vector2d>>;

/// Points of each image by its id. What else the file says has been checked.
Pixels read_pixels(std::string_view bytes, const std::string& name) {
  constexpr std::size_t kLeastBytes = 4 + 7 * 8 + 4 + 1 + 8, kPointBytes = 24, kMaxNameChars = 4096;
  Pixels pixels;
  ByteReader in(bytes, name + "/images.bin");
  for (std::uint64_t left = in.count(kLeastBytes); left > 0; --left) {
    const auto id = in.take<std::int32_t>();
    for (int i = 0; i < 7; ++i) in.take<double>();
    in.take<std::int32_t>();
    in.text(kMaxNameChars);
    std::vector<Eigen::Vector2d>& own = pixels[id];
    own.resize(in.count(kPointBytes));
    for (Eigen::Vector2d& pixel : own) {
      // From the image's corner to the first pixel's centre.
      pixel.x() = in.take<double>() - 0.5;
      pixel.y() = in.take<double>() - 0.5;
      in.take<std::uint64_t>();
    }
  }
  return pixels;
}

ColmapSighting read_sighting(ByteReader& in, const Pixels& pixels) {
  const std::string where = in.where();
  const auto image = in.take<std::int32_t>();
  const auto index = in.take<std::int32_t>();
  const auto own = pixels.find(image);
  if (own == pixels.end()) {
    throw std::runtime_error(where + "image " + std::to_string(image) +
                             " is not in the file of images");
  }
  if (index < 0 || static_cast<std::size_t>(index) >= own->second.size()) {
    throw std::runtime_error(where + "point " + std::to_string(index) + " of image " +
                             std::to_string(image) + ", which has " +
                             std::to_string(own->second.size()));
  }
  const Eigen::Vector2d pixel_px = own->second[static_cast<std::size_t>(index)];
  if (!pixel_px.allFinite())
    throw std::runtime_error(where + "the pixel of a sighting is not finite");
  return {image, pixel_px};
}

ColmapPoint read_point(ByteReader& in, const Pixels& pixels, const std::string& where) {
  constexpr std::size_t kSightingBytes = 8;
  ColmapPoint point;
  for (int k = 0; k < 3; ++k) point.in_world[k] = in.take<double>();
  if (!point.in_world.allFinite()) throw std::runtime_error(where + "the point is not finite");
  point.color.r = in.take<std::uint8_t>();
  point.color.g = in.take<std::uint8_t>();
  point.color.b = in.take<std::uint8_t>();
  point.error_px = in.take<double>();
  if (!std::isfinite(point.error_px)) throw std::runtime_error(where + "its error is not finite");
  const std::uint64_t sightings = in.count(kSightingBytes);
  point.sightings.reserve(sightings);
  for (std::uint64_t i = 0; i < sightings; ++i)
    point.sightings.push_back(read_sighting(in, pixels));
  return point;
}

}  // namespace

ColmapTracks colmap_tracks_from_binary(const ColmapFiles& files, const std::string& name) {
  constexpr std::size_t kLeastBytes = 8 + 3 * 8 + 3 + 8 + 8;
  ColmapTracks tracks;
  tracks.model = colmap_from_binary(files, name);
  const Pixels pixels = read_pixels(files.images, name);
  std::map<std::uint64_t, ColmapPoint> points;
  ByteReader in(files.points, name + "/points3D.bin");
  for (std::uint64_t left = in.count(kLeastBytes); left > 0; --left) {
    const std::string where = in.where();
    const auto id = in.take<std::uint64_t>();
    if (!points.emplace(id, read_point(in, pixels, where)).second)
      throw std::runtime_error(where + "point " + std::to_string(id) + " occurs twice");
  }
  for (auto& [id, point] : points) tracks.points.push_back(std::move(point));
  return tracks;
}

}  // namespace cousin
