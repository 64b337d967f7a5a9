#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string_view>

#include "sim/geometry/measure.h"
#include "sim/geometry/mesh_formats.h"

/// Any bytes as glTF, whose buffers hold as many bytes as the file: a mesh that the check and the
/// weld accept, or std::runtime_error, nothing else.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cousin;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const geometry::OpenFile open = [&](const std::string&) { return std::string(bytes); };
  try {
    check_watertight(weld(geometry::parse_gltf(bytes, "fuzz", open, 100'000).user.mesh));
  } catch (const std::runtime_error&) {
  }
  return 0;
}
