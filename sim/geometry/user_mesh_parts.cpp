#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

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

UserMesh user_mesh_of_ply(const Ply& ply, const std::string& name) {
  UserMesh user;
  user.mesh = mesh_of_ply(ply, name);
  const PlyElement& vertices = *ply.element("vertex");
  const std::vector<double>* channels[3] = {vertices.column("red"), vertices.column("green"),
                                            vertices.column("blue")};
  if (!channels[0] || !channels[1] || !channels[2]) return user;
  double full = 255;
  for (std::size_t k = 0; k < vertices.columns.size(); ++k) {
    if (vertices.columns[k] == "red" && vertices.is_float[k]) full = 1;
  }
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
  return user;
}

}  // namespace cousin::geometry
