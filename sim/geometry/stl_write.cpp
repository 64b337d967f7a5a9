#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "sim/geometry/mesh_formats.h"
#include "sim/geometry/mesh_io.h"

namespace cousin {
namespace {

static_assert(std::endian::native == std::endian::little);

void put_floats(std::string& bytes, const Eigen::Vector3f& v) {
  char raw[12];
  std::memcpy(raw, v.data(), sizeof raw);
  bytes.append(raw, sizeof raw);
}

}  // namespace

void write_stl(const std::filesystem::path& file, const Mesh& mesh, double factor) {
  if (mesh.triangles.size() > std::numeric_limits<std::uint32_t>::max())
    throw std::invalid_argument(file.string() + ": STL holds fewer than 2^32 triangles");
  std::string bytes(80, '\0');
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  char raw[4];
  std::memcpy(raw, &count, sizeof raw);
  bytes.append(raw, sizeof raw);
  bytes.reserve(84 + 50 * mesh.triangles.size());
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices_m[t[0]], b = mesh.vertices_m[t[1]],
                          c = mesh.vertices_m[t[2]];
    put_floats(bytes, (b - a).cross(c - a).normalized().cast<float>());
    for (const Eigen::Vector3d& corner : {a, b, c})
      put_floats(bytes, Eigen::Vector3d(factor * corner).cast<float>());
    bytes.append(2, '\0');  // attributes
  }
  geometry::write_whole(file, bytes);
}

}  // namespace cousin
