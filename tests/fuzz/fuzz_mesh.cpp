#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string_view>

#include "sim/geometry/measure.h"
#include "sim/geometry/mesh_formats.h"

/// Any bytes as PLY, OBJ and STL: a mesh that the check and the weld accept, or std::runtime_error,
/// nothing else.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cousin;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const auto attempt = [&](auto read) {
    try {
      check_watertight(weld(read().mesh));
    } catch (const std::runtime_error&) {
    }
  };
  attempt([&] { return geometry::user_mesh_of_ply(geometry::parse_ply(bytes, "fuzz"), "fuzz"); });
  attempt([&] { return geometry::parse_obj(bytes, "fuzz"); });
  attempt([&] { return geometry::parse_stl(bytes, "fuzz"); });
  return 0;
}
