#include <cstddef>
#include <cstdint>
#include <stdexcept>

#include "sim/imaging/npy.h"

/// Any bytes as a .npy file of either shape: an image or std::runtime_error, nothing else.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto attempt = [&](auto decode) {
    try {
      decode({data, size}, "fuzz");
    } catch (const std::runtime_error&) {
    }
  };
  attempt(cousin::imaging::decode_npy);
  attempt(cousin::imaging::decode_npy_vectors);
  return 0;
}
