#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "sim/dataset/colmap_model.h"

/// Any bytes, of which the first is the length of cameras.bin and the rest are that file and
/// images.bin: a model or std::runtime_error, nothing else.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  const std::size_t cut = std::min<std::size_t>(data[0], bytes.size());
  cousin::ColmapFiles files;
  files.cameras = bytes.substr(0, cut);
  files.images = bytes.substr(cut);
  try {
    cousin::colmap_from_binary(files, "fuzz");
  } catch (const std::runtime_error&) {
  }
  return 0;
}
