#include "sim/plant/mesh_plant.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <numeric>
#include <unordered_map>

namespace cousin {
namespace {

bool uses_a_vertex_twice(const std::array<std::uint32_t, 3>& t) {
  return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

/// Some triangles with the vertices that they use.
void add_triangles(Organ& organ, const UserMesh& user, const std::vector<std::size_t>& triangles,
                   const MeshPlacing& placing) {
  std::unordered_map<std::uint32_t, std::uint32_t> number;
  Mesh& mesh = organ.surface.mesh;
  const auto vertex = [&](std::uint32_t v) {
    const auto [found, is_new] =
        number.try_emplace(v, static_cast<std::uint32_t>(mesh.vertices_m.size()));
    if (is_new) {
      mesh.vertices_m.push_back(placing.metres_per_unit *
                                (placing.ours_from_file * user.mesh.vertices_m[v]));
      if (!user.vertex_albedo.empty()) organ.albedo.push_back(user.vertex_albedo[v]);
    }
    return found->second;
  };
  for (const std::size_t t : triangles) {
    const auto& [a, b, c] = user.mesh.triangles[t];
    if (uses_a_vertex_twice(user.mesh.triangles[t])) continue;
    const std::uint32_t first = vertex(a), second = vertex(b);  // in this order
    mesh.triangles.push_back({first, second, vertex(c)});
  }
}

/// Numbers of the triangles of each part; of all, where there are no parts.
std::vector<std::vector<std::size_t>> triangles_of_parts(const UserMesh& user) {
  std::vector<std::vector<std::size_t>> parts(std::max<std::size_t>(1, user.part_names.size()));
  for (std::size_t t = 0; t < user.mesh.triangles.size(); ++t)
    parts[user.triangle_part.empty() ? 0 : user.triangle_part[t]].push_back(t);
  return parts;
}

}  // namespace

OrganKind organ_kind_of(const std::string& name) {
  std::string low = name;
  for (char& c : low) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  struct Row {
    const char* word;
    OrganKind kind;
  };
  // The first that is found: a leaf's petiole is a petiole.
  constexpr std::array<Row, 16> kWords = {{{"petiole", OrganKind::petiole},
                                           {"sheath", OrganKind::sheath},
                                           {"ligule", OrganKind::ligule},
                                           {"cotyledon", OrganKind::cotyledon},
                                           {"leaf", OrganKind::blade},
                                           {"leaves", OrganKind::blade},
                                           {"blade", OrganKind::blade},
                                           {"lamina", OrganKind::blade},
                                           {"flower", OrganKind::flower},
                                           {"tassel", OrganKind::flower},
                                           {"petal", OrganKind::flower},
                                           {"fruit", OrganKind::fruit},
                                           {"berry", OrganKind::fruit},
                                           {"apple", OrganKind::fruit},
                                           {"root", OrganKind::root},
                                           {"stem", OrganKind::stem}}};
  for (const Row& row : kWords) {
    if (low.find(row.word) != std::string::npos) return row.kind;
  }
  return OrganKind::stem;
}

void set_surface(Organ& organ, const UserMesh& user, const MeshPlacing& placing) {
  organ.surface = {};
  organ.albedo.clear();
  std::vector<std::size_t> all(user.mesh.triangles.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  add_triangles(organ, user, all, placing);
}

Plant plant_of_mesh(const UserMesh& user, const MeshPlacing& placing, const std::string& name) {
  Plant plant;
  plant.name = name;
  if (user.triangle_part.empty()) {
    set_surface(add_organ(plant, OrganKind::stem, name, -1, 0), user, placing);
    return plant;
  }
  const std::vector<std::vector<std::size_t>> parts = triangles_of_parts(user);
  for (std::size_t part = 0; part < user.part_names.size(); ++part) {
    const std::string& own = user.part_names[part];
    add_triangles(add_organ(plant, organ_kind_of(own), own, -1, 0), user, parts[part], placing);
  }
  return plant;
}

}  // namespace cousin
