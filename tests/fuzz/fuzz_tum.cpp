#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string_view>

#include "sim/dataset/import.h"

/// Any bytes as a list of files and as one of poses: either or std::runtime_error, nothing else.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    cousin::tum_files(text, "fuzz");
  } catch (const std::runtime_error&) {
  }
  try {
    cousin::tum_poses(text, "fuzz");
  } catch (const std::runtime_error&) {
  }
  return 0;
}
