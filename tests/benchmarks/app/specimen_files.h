#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <sstream>
#include <vector>

#include "sim/dataset/atomic_file.h"
#include "tests/sim/physics/solids.h"

namespace cousin {

/// Closed meshes as one Wavefront file, in the unit they are given in.
inline void write_obj(const std::filesystem::path& file, const std::vector<Mesh>& meshes) {
  std::ostringstream text;
  std::uint32_t first = 1;
  for (const Mesh& mesh : meshes) {
    for (const Eigen::Vector3d& v : mesh.vertices_m)
      text << "v " << v.x() << " " << v.y() << " " << v.z() << "\n";
    for (const auto& t : mesh.triangles)
      text << "f " << t[0] + first << " " << t[1] + first << " " << t[2] + first << "\n";
    first += static_cast<std::uint32_t>(mesh.vertices_m.size());
  }
  write_file(file, text.str());
}

inline void write_box_obj(const std::filesystem::path& file, const Eigen::Vector3d& size) {
  write_obj(file, {box_solid(size)});
}

}  // namespace cousin
