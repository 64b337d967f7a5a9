#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string_view>

#include "sim/dataset/photograph_labels.h"

/// Any bytes: names of pictures or std::runtime_error, nothing else; what was read can be written
/// and read again.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  cousin::PhotographLabels seam;
  try {
    seam = cousin::pictures_from_json({reinterpret_cast<const char*>(data), size}, "fuzz");
  } catch (const std::runtime_error&) {
    return 0;
  }
  cousin::pictures_from_json(cousin::pictures_to_json(seam), "again");
  return 0;
}
