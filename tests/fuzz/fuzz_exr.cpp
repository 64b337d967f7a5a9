#include <cstddef>
#include <cstdint>
#include <stdexcept>

#include "sim/imaging/codecs.h"

/// Any bytes as an OpenEXR file: an image or std::runtime_error, nothing else.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    cousin::imaging::decode_exr({data, size}, "fuzz", {{"Z"}, {"R", "G", "B"}, {"Y"}, {}}, 0);
  } catch (const std::runtime_error&) {
  }
  return 0;
}
