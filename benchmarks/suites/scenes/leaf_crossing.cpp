#include "benchmarks/suites/scenes/leaf_crossing.h"

#include <algorithm>

#include "sim/truth/specimens.h"

namespace cousin {

SurfaceCrossing leaf_crossing(const Scene& scene) {
  return leaf_crossing(scene, specimens_of(scene));
}

SurfaceCrossing leaf_crossing(const Scene& scene, const std::vector<const Instance*>& plants) {
  Mesh all;
  std::vector<int> sheets;
  int first_sheet = 0;
  for (const Instance* instance : plants) {
    const ObjectModel& model = scene.models[static_cast<std::size_t>(instance->model)];
    const Mesh mesh = mesh_in_world(scene, *instance);
    const auto offset = static_cast<std::uint32_t>(all.vertices_m.size());
    all.vertices_m.insert(all.vertices_m.end(), mesh.vertices_m.begin(), mesh.vertices_m.end());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const std::size_t part = model.triangle_part.empty() ? 0 : model.triangle_part[t];
      const int look =
          instance->part_materials.empty() ? instance->material : instance->part_materials[part];
      const bool is_leaf =
          scene.materials[static_cast<std::size_t>(look)].kind == SurfaceKind::leaf;
      sheets.push_back(is_leaf ? first_sheet + static_cast<int>(part) : -1);
      const auto& [a, b, c] = mesh.triangles[t];
      all.triangles.push_back({a + offset, b + offset, c + offset});
    }
    first_sheet += static_cast<int>(std::max<std::size_t>(1, model.part_names.size()));
  }
  return surface_crossing(all, sheets);
}

}  // namespace cousin
