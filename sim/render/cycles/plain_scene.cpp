#include "sim/render/cycles/plain_scene.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>
#include <variant>

#include "sim/render/cycles/painted_noise.h"
#include "sim/types/board.h"

namespace cousin {
namespace {

constexpr double kMostCells = 4e6;

/// Whether a triangle lies in the face that prints are on, z = 0 but for its bend.
bool in_face(const Mesh& mesh, const std::array<std::uint32_t, 3>& triangle, double bend_m) {
  return std::all_of(triangle.begin(), triangle.end(), [&](std::uint32_t v) {
    return std::abs(mesh.vertices_m[v].z()) < bend_m + 1e-9;
  });
}

/// The model with its printed face as a grid of coloured cells in place of the face's triangles.
ObjectModel with_print(const ObjectModel& model, const Material& material, double cell_m) {
  Eigen::Vector2d low(1e300, 1e300), high(-1e300, -1e300);
  ObjectModel out = model;
  out.mesh.triangles.clear();
  out.triangle_part.clear();
  out.part_names.clear();
  out.vertex_normals.clear();
  for (const auto& triangle : model.mesh.triangles) {
    if (!in_face(model.mesh, triangle, material.print_bend_m)) {
      out.mesh.triangles.push_back(triangle);
      continue;
    }
    for (const std::uint32_t v : triangle) {
      low = low.cwiseMin(model.mesh.vertices_m[v].head<2>());
      high = high.cwiseMax(model.mesh.vertices_m[v].head<2>());
    }
  }
  if (low.x() > high.x()) return model;  // no face to print on
  const Eigen::Vector2d cells = ((high - low) / cell_m).array().ceil().max(1.0);
  if (!(cells.prod() <= kMostCells)) {
    throw std::invalid_argument("model \"" + model.name + "\": its print would take " +
                                std::to_string(cells.prod()) + " cells; the limit is 4000000");
  }
  const auto columns = static_cast<std::uint32_t>(cells.x());
  const auto rows = static_cast<std::uint32_t>(cells.y());
  if (out.vertex_albedo.empty())
    out.vertex_albedo.assign(out.mesh.vertices_m.size(), Rgbf{1, 1, 1});
  const auto ratio = [](float ink, float paper) { return paper > 0 ? ink / paper : 0.0F; };
  const Rgbf ink{ratio(material.ink_albedo.r, material.albedo.r),
                 ratio(material.ink_albedo.g, material.albedo.g),
                 ratio(material.ink_albedo.b, material.albedo.b)};
  // Four vertices of its own for each cell: the print's edges stay sharp to a cell.
  for (std::uint32_t j = 0; j < rows; ++j) {
    for (std::uint32_t i = 0; i < columns; ++i) {
      const Eigen::Vector2d step = (high - low).cwiseQuotient(cells);
      const Eigen::Vector2d corner = low + step.cwiseProduct(Eigen::Vector2d(i, j));
      const Eigen::Vector2d middle = corner + 0.5 * step;
      const Rgbf color = is_black(*material.print, middle.x(), middle.y()) ? ink : Rgbf{1, 1, 1};
      const auto first = static_cast<std::uint32_t>(out.mesh.vertices_m.size());
      for (const auto& [dx, dy] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
        out.mesh.vertices_m.emplace_back(corner.x() + dx * step.x(), corner.y() + dy * step.y(), 0);
        out.vertex_albedo.push_back(color);
      }
      out.mesh.triangles.push_back({first, first + 1, first + 2});
      out.mesh.triangles.push_back({first, first + 2, first + 3});
    }
  }
  return out;
}

void paint_prints(PlainScene& plain, double cell_m) {
  for (Instance& instance : plain.scene.instances) {
    const Material& material = plain.scene.materials[static_cast<std::size_t>(instance.material)];
    if (!material.print) continue;
    // A model of its own: others may share this one without the print.
    plain.scene.models.push_back(
        with_print(plain.scene.models[static_cast<std::size_t>(instance.model)], material, cell_m));
    instance.model = static_cast<int>(plain.scene.models.size()) - 1;
    plain.changes.push_back("the print of \"" + instance.name + "\" is colours of " +
                            std::to_string(cell_m * 1000) + " mm cells" +
                            (material.print_bend_m > 0 ? ", on a flat face" : ""));
  }
}

/// The triangles of one material of an instance, with all vertices.
ObjectModel of_material(const ObjectModel& model, const Instance& instance, int material) {
  ObjectModel out = model;
  out.name += " " + std::to_string(material);
  out.mesh.triangles.clear();
  out.triangle_part.clear();
  for (std::size_t i = 0; i < model.mesh.triangles.size(); ++i) {
    const std::uint16_t part = model.triangle_part.empty() ? 0 : model.triangle_part[i];
    if (instance.part_materials[part] != material) continue;
    out.mesh.triangles.push_back(model.mesh.triangles[i]);
    out.triangle_part.push_back(part);
  }
  return out;
}

/// One instance for each material of an instance whose parts differ in theirs.
void split_materials(PlainScene& plain) {
  std::vector<Instance> whole;
  whole.swap(plain.scene.instances);
  int next_id = 0;
  for (const Instance& instance : whole) next_id = std::max(next_id, instance.id + 1);
  for (Instance& instance : whole) {
    instance.part_of = -1;
    instance.keypoint_carriers.clear();
    if (instance.part_materials.empty()) {
      plain.scene.instances.push_back(instance);
      continue;
    }
    const std::set<int> materials(instance.part_materials.begin(), instance.part_materials.end());
    for (const int material : materials) {
      Instance part = instance;
      if (material != *materials.begin()) part.id = next_id++;
      part.material = material;
      part.part_materials.clear();
      ObjectModel model = of_material(plain.scene.models[static_cast<std::size_t>(instance.model)],
                                      instance, material);
      if (model.mesh.triangles.empty()) continue;
      part.model = static_cast<int>(plain.scene.models.size());
      plain.scene.models.push_back(std::move(model));
      plain.scene.instances.push_back(std::move(part));
    }
  }
}

/// Noise as vertex colours: models and materials of their own for those that have it.
void paint_noises(PlainScene& plain) {
  struct Painted {
    int model = 0, material = 0;
  };
  std::map<std::pair<int, int>, Painted> done;  // by model and material
  for (Instance& instance : plain.scene.instances) {
    const Material& material = plain.scene.materials[static_cast<std::size_t>(instance.material)];
    if (!material.noise) continue;
    const std::pair<int, int> key = {instance.model, instance.material};
    if (!done.contains(key)) {
      PaintedNoise painted =
          paint_noise(plain.scene.models[static_cast<std::size_t>(instance.model)], material);
      plain.changes.push_back("the noise of \"" + material.name + "\" on \"" + painted.model.name +
                              "\" is colours of vertices at most " +
                              std::to_string(1000 * painted.cell_m) + " mm apart where it is cut");
      done[key] = {static_cast<int>(plain.scene.models.size()),
                   static_cast<int>(plain.scene.materials.size())};
      plain.scene.models.push_back(std::move(painted.model));
      plain.scene.materials.push_back(std::move(painted.material));
    }
    instance.model = done[key].model;
    instance.material = done[key].material;
  }
}

void plain_materials(PlainScene& plain) {
  for (Material& material : plain.scene.materials) {
    if (material.back_albedo)
      plain.changes.push_back("material \"" + material.name + "\" has lost its back's colour");
    material.print.reset();
    material.noise.reset();
    material.back_albedo.reset();
  }
}

void plain_lights(PlainScene& plain) {
  const auto projectors = std::erase_if(plain.scene.lights, [](const Light& light) {
    return std::holds_alternative<Projector>(light);
  });
  if (projectors > 0)
    plain.changes.push_back(std::to_string(projectors) + " projectors are left out");
}

void plain_lens(PlainScene& plain) {
  Camera& camera = plain.view.camera;
  if (camera.model == LensModel::pinhole) return;
  plain.changes.push_back("the lens is a pinhole in place of " +
                          std::string(to_string(camera.model)));
  camera.model = LensModel::pinhole;
  camera.distortion = {};
  camera.spline = {};
}

}  // namespace

PlainScene plain_scene(const Scene& scene, const TrueView& view, double print_cell_m) {
  validate(scene);
  if (!(print_cell_m > 0)) {
    throw std::invalid_argument("print_cell_m = " + std::to_string(print_cell_m) +
                                " must be positive");
  }
  PlainScene plain{scene, view, {}};
  split_materials(plain);
  paint_noises(plain);
  paint_prints(plain, print_cell_m);
  plain_materials(plain);
  plain_lights(plain);
  plain_lens(plain);
  return plain;
}

}  // namespace cousin
