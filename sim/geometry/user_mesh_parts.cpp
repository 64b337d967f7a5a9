#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>
#include <string_view>

#include "sim/geometry/mesh_formats.h"

namespace cousin::geometry {

float linear_of_srgb(float srgb) {
  return srgb <= 0.04045F ? srgb / 12.92F : std::pow((srgb + 0.055F) / 1.055F, 2.4F);
}

void name_parts(UserMesh& user) {
  const std::set<std::string> given(user.part_names.begin(), user.part_names.end());
  std::map<std::string, int> times;  // that a name has come
  for (std::string& name : user.part_names) {
    if (name.empty()) name = "part";
    const std::string wished = name;
    int& time = times[wished];
    while (++time > 1) {
      name = wished + " " + std::to_string(time);
      if (!given.contains(name)) break;  // else another part has it by right
    }
  }
}

namespace {

/// Red, green and blue by one of their names, or nulls.
std::array<const std::vector<double>*, 3> colours_of(const PlyElement& vertices, bool& is_float) {
  constexpr std::array<std::array<std::string_view, 3>, 2> kNames = {
      {{"red", "green", "blue"}, {"diffuse_red", "diffuse_green", "diffuse_blue"}}};
  for (const auto& names : kNames) {
    const std::array channels = {vertices.column(names[0]), vertices.column(names[1]),
                                 vertices.column(names[2])};
    if (!channels[0] || !channels[1] || !channels[2]) continue;
    for (std::size_t k = 0; k < vertices.columns.size(); ++k) {
      if (vertices.columns[k] == names[0]) is_float = vertices.is_float[k];
    }
    return channels;
  }
  return {};
}

void add_colours(const PlyElement& vertices, UserMesh& user, const std::string& name) {
  bool is_float = false;
  const auto channels = colours_of(vertices, is_float);
  if (!channels[0]) return;
  const double full = is_float ? 1 : 255;
  user.vertex_albedo.resize(vertices.count);
  for (std::size_t i = 0; i < vertices.count; ++i) {
    float linear[3];
    for (std::size_t k = 0; k < 3; ++k) {
      const double value = (*channels[k])[i];
      if (!(value >= 0 && value <= full)) {
        throw std::runtime_error(name + ": vertex " + std::to_string(i) + ": the colour " +
                                 std::to_string(value) + " is not in [0, " +
                                 (full > 1 ? "255" : "1") + "]");
      }
      linear[k] = linear_of_srgb(static_cast<float>(value / full));
    }
    user.vertex_albedo[i] = {linear[0], linear[1], linear[2]};
  }
}

}  // namespace

MeshFile user_mesh_of_ply(const Ply& ply, const std::string& name) {
  MeshFile file;
  UserMesh& user = file.user;
  user.mesh = mesh_of_ply(ply, name);
  add_colours(*ply.element("vertex"), user, name);
  const bool has_texture =
      std::any_of(ply.comments.begin(), ply.comments.end(),
                  [](const std::string& text) { return text.starts_with("TextureFile"); });
  if (has_texture && user.vertex_albedo.empty()) {
    file.warnings.push_back(name +
                            ": its texture (TextureFile) is not read: the surface has the colour "
                            "of the configuration");
  }
  if (ply.bytes_left > 0) {
    file.warnings.push_back(name + ": " + std::to_string(ply.bytes_left) +
                            " bytes behind the rows that the header counts are not read");
  }
  return file;
}

}  // namespace cousin::geometry
