#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string_view>

#include "sim/dataset/seam_json.h"

/// Any bytes: keypoints or std::runtime_error, nothing else; what was read can be written and read
/// again.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  cousin::Keypoints seam;
  try {
    seam = cousin::keypoints_from_json({reinterpret_cast<const char*>(data), size}, "fuzz");
  } catch (const std::runtime_error&) {
    return 0;
  }
  cousin::keypoints_from_json(cousin::keypoints_to_json(seam, 0), "again");
  return 0;
}
