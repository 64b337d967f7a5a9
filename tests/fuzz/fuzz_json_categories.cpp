#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "sim/dataset/categories.h"

/// Any bytes: names or std::runtime_error, nothing else; what was read can be written and read
/// again.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::vector<std::string> names;
  try {
    names = cousin::categories_from_json({reinterpret_cast<const char*>(data), size}, "fuzz");
  } catch (const std::runtime_error&) {
    return 0;
  }
  cousin::categories_from_json(cousin::categories_to_json(names), "again");
  return 0;
}
