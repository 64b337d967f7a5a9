#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "benchmarks/tools/calibrate/calibration_photos.h"

/// Any text: a board that is valid or std::invalid_argument, nothing else.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    validate(cousin::target_from_option(text));
  } catch (const std::invalid_argument&) {
  }
  return 0;
}
