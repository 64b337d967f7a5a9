#include "sim/geometry/user_mesh.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <stdexcept>
#include <string_view>

#include "sim/geometry/measure.h"
#include "sim/geometry/mesh_formats.h"
#include "sim/geometry/mesh_io.h"
#include "sim/geometry/mesh_warnings.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

std::string ending_of(const fs::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

geometry::MeshFile parse(const fs::path& file, std::size_t most) {
  const std::string name = file.string(), extension = ending_of(file);
  constexpr std::array kEndings = {".ply", ".obj", ".stl", ".gltf", ".glb"};
  if (std::find(kEndings.begin(), kEndings.end(), extension) == kEndings.end()) {
    throw std::runtime_error(name + ": the ending \"" + extension +
                             "\" is not one of .ply, .obj, .stl, .gltf, .glb");
  }
  const std::string bytes = geometry::read_whole(file);
  if (extension == ".ply")
    return geometry::user_mesh_of_ply(geometry::parse_ply(bytes, name), name);
  if (extension == ".obj") return geometry::parse_obj(bytes, name, most);
  if (extension == ".stl") return geometry::parse_stl(bytes, name);
  return geometry::parse_gltf(bytes, name, geometry::files_beside(file), most);
}

}  // namespace

UserMesh read_user_mesh(const fs::path& file, std::size_t most_triangles) {
  UserMesh user = parse(file, most_triangles).user;
  if (user.mesh.triangles.size() > most_triangles) {
    throw std::runtime_error(file.string() + ": " + std::to_string(user.mesh.triangles.size()) +
                             " triangles; the limit is " + std::to_string(most_triangles));
  }
  return user;
}

UserMesh welded(const UserMesh& user) {
  UserMesh result;
  result.mesh = weld(user.mesh);
  result.is_in_metres = user.is_in_metres;
  if (user.vertex_albedo.empty()) return result;
  // weld() keeps vertices in the order of their first coming.
  for (std::size_t i = 0; i < user.mesh.vertices_m.size(); ++i) {
    const std::size_t next = result.vertex_albedo.size();
    if (next == result.mesh.vertices_m.size()) break;
    if (user.mesh.vertices_m[i] == result.mesh.vertices_m[next])
      result.vertex_albedo.push_back(user.vertex_albedo[i]);
  }
  return result;
}

std::vector<std::string> user_mesh_warnings(const fs::path& file) {
  return parse(file, kMostUserTriangles).warnings;
}

double metres_per_unit(const std::string& unit) {
  struct Row {
    std::string_view name;
    double metres;
  };
  constexpr std::array<Row, 7> kUnits = {{{"m", 1},
                                          {"dm", 0.1},
                                          {"cm", 0.01},
                                          {"mm", 1e-3},
                                          {"um", 1e-6},
                                          {"in", 0.0254},
                                          {"ft", 0.3048}}};
  std::string names;
  for (const Row& row : kUnits) {
    if (row.name == unit) return row.metres;
    names += (names.empty() ? "" : ", ") + std::string(row.name);
  }
  throw std::invalid_argument("unit \"" + unit + "\" is not one of " + names);
}

Mesh read_mesh(const fs::path& file) {
  constexpr std::size_t kMost = geometry::kMaxElements;
  Mesh mesh = std::move(parse(file, kMost).user.mesh);
  // STL repeats the corners of each triangle, glTF those on seams.
  const std::string extension = ending_of(file);
  return extension == ".ply" || extension == ".obj" ? mesh : weld(mesh);
}

}  // namespace cousin
