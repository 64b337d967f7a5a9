#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "sim/dataset/colmap_tracks.h"

/// Any bytes, of which the first two are the lengths of cameras.bin and (times four) of images.bin,
/// and the rest are these files and points3D.bin: a model or std::runtime_error, nothing else.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const std::string bytes(reinterpret_cast<const char*>(data) + 2, size - 2);
  const std::size_t cameras = std::min<std::size_t>(data[0], bytes.size());
  const std::size_t images = std::min<std::size_t>(4 * data[1], bytes.size() - cameras);
  cousin::ColmapFiles files;
  files.cameras = bytes.substr(0, cameras);
  files.images = bytes.substr(cameras, images);
  files.points = bytes.substr(cameras + images);
  try {
    cousin::colmap_tracks_from_binary(files, "fuzz");
  } catch (const std::runtime_error&) {
  }
  return 0;
}
