#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string_view>

#include "sim/dataset/camera_files.h"

/// Any bytes: a camera or std::runtime_error, nothing else.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    cousin::camera_from_mrcal(text, "fuzz");
  } catch (const std::runtime_error&) {
  }
  return 0;
}
