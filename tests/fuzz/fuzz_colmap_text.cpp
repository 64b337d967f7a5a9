#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "sim/dataset/colmap_model.h"

/// Any bytes, cameras.txt before a line "---" and images.txt after it: a model or
/// std::runtime_error, nothing else.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  const std::string between = "---\n";
  const std::size_t cut = text.find(between);
  cousin::ColmapFiles files;
  files.cameras = text.substr(0, cut);
  if (cut != std::string::npos) files.images = text.substr(cut + between.size());
  try {
    cousin::colmap_from_text(files, "fuzz");
  } catch (const std::runtime_error&) {
  }
  return 0;
}
