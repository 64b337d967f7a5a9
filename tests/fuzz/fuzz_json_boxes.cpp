#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string_view>

#include "sim/dataset/seam_json.h"

/// Any bytes: boxes or std::runtime_error, nothing else; what was read can be written and read
/// again.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  cousin::Boxes seam;
  try {
    seam = cousin::boxes_from_json({reinterpret_cast<const char*>(data), size}, "fuzz");
  } catch (const std::runtime_error&) {
    return 0;
  }
  cousin::boxes_from_json(cousin::boxes_to_json(seam, 0), "again");
  return 0;
}
