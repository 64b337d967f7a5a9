#include "sim/geometry/mesh_io.h"

#include <cctype>
#include <stdexcept>
#include <string>

#include "sim/geometry/measure.h"
#include "sim/geometry/mesh_formats.h"

namespace cousin {
namespace fs = std::filesystem;
Mesh read_mesh(const fs::path& file) {
  const std::string bytes = geometry::read_whole(file);
  const std::string name = file.string();
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (extension == ".ply") return geometry::mesh_of_ply(geometry::parse_ply(bytes, name), name);
  if (extension == ".obj") return geometry::parse_obj(bytes, name);
  if (extension == ".stl") return weld(geometry::parse_stl(bytes, name));
  throw std::runtime_error(name + ": the ending \"" + extension +
                           "\" is not one of .ply, .obj, .stl");
}

}  // namespace cousin
