#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string_view>

#include "sim/sensors/rig.h"

/// Any bytes as the TOML of a rig: a rig that can be made, or std::runtime_error.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const cousin::RigConfig rig = cousin::rig_from_toml(text, "fuzz");
    cousin::validate(rig);
  } catch (const std::runtime_error&) {
  }
  return 0;
}
