#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string_view>

#include "sim/dataset/seam_json.h"

/// Any bytes: tracks or std::runtime_error, nothing else; what was read can be written and read
/// again.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  cousin::Tracks seam;
  try {
    seam = cousin::tracks_from_json({reinterpret_cast<const char*>(data), size}, "fuzz");
  } catch (const std::runtime_error&) {
    return 0;
  }
  cousin::tracks_from_json(cousin::tracks_to_json(seam), "again");
  return 0;
}
