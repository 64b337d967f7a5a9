#include <cstddef>
#include <cstdint>
#include <stdexcept>

#include "sim/imaging/codecs.h"

/// Any bytes as a PNG of each kind, or as a JPEG: an image or std::runtime_error, nothing else.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cousin;
  const std::span<const std::uint8_t> bytes(data, size);
  const auto attempt = [&](auto decode) {
    try {
      decode(bytes, "fuzz");
    } catch (const std::runtime_error&) {
    }
  };
  if (imaging::is_jpeg(bytes)) {
    attempt(imaging::decode_jpeg);
  } else {
    attempt(imaging::decode_png_color);
    attempt(imaging::decode_png8);
    attempt(imaging::decode_png16);
  }
  return 0;
}
