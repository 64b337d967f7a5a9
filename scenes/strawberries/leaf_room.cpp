#include "scenes/strawberries/leaf_room.h"

#include <algorithm>

#include "scenes/strawberries/bed_outline.h"
#include "scenes/strawberries/strawberries_scene.h"
#include "sim/geometry/smooth_normals.h"

namespace cousin {

using Eigen::Vector3d;

HangingFruit::HangingFruit(const Mesh& mesh, const Pose& world_from_fruit)
    : hull(mesh),
      fruit_from_world(inverse(world_from_fruit)),
      centre_m(world_from_fruit.translation_m) {
  for (const Vector3d& p : mesh.vertices_m) radius_m = std::max(radius_m, p.norm());
}

double HangingFruit::depth_m(const Vector3d& in_world_m, double far_m) const {
  if ((in_world_m - centre_m).norm() > radius_m + far_m) return -far_m;
  return std::max(-far_m, hull.depth_m(fruit_from_world * in_world_m, -far_m));
}

std::vector<HangingFruit> hanging_fruits(const std::vector<Truss>& trusses) {
  std::vector<HangingFruit> fruits;
  for (const Truss& truss : trusses) {
    for (std::size_t i = 0; i < truss.fruits.size(); ++i)
      fruits.emplace_back(truss.fruits[i].hull, truss.world_from_fruit[i]);
  }
  return fruits;
}

void lay_sepals(std::vector<Truss>& trusses, double clear_m) {
  const std::vector<HangingFruit> fruits = hanging_fruits(trusses);
  constexpr double kStep_m = 2e-4;
  std::size_t own = 0;
  for (Truss& truss : trusses) {
    for (std::size_t i = 0; i < truss.fruits.size(); ++i, ++own) {
      const Pose& at = truss.world_from_fruit[i];
      ObjectModel& calyx = truss.fruits[i].calyx.model;
      bool is_moved = false;
      for (Vector3d& vertex : calyx.mesh.vertices_m) {
        Vector3d p = at * vertex;
        for (std::size_t k = 0; k < fruits.size(); ++k) {
          if (k == own || fruits[k].depth_m(p, 2 * clear_m) <= -clear_m) continue;
          const Vector3d out = (p - fruits[k].centre_m).normalized();
          while (fruits[k].depth_m(p, 2 * clear_m) > -clear_m) p += kStep_m * out;
          vertex = inverse(at) * p;
          is_moved = true;
        }
      }
      if (is_moved && !calyx.vertex_normals.empty())
        calyx.vertex_normals = smooth_normals(calyx.mesh);
    }
  }
}

bool TrussLeafRoom::is_free(const Mesh& part, const Pose& world_from_part) const {
  for (const Vector3d& vertex : part.vertices_m) {
    const Vector3d p = world_from_part * vertex;
    if (depth_m(bed, p) > 0) return false;
    for (const HangingFruit& fruit : fruits) {
      if (fruit.depth_m(p, 2 * clear_m) > -clear_m) return false;
    }
  }
  return true;
}

namespace {

constexpr double kFar_m = 0.01;

HangingFruit fruit_of(const Scene& scene, const Instance& instance) {
  return {contact_hull(scene.models[static_cast<std::size_t>(instance.model)].mesh),
          instance.world_from_object};
}

/// Deepest point of a sheet's triangles in a fruit.
double sheet_depth_m(const Mesh& mesh, const HangingFruit& fruit) {
  constexpr int kCells = 4;  // of a triangle's edge
  double deepest = -kFar_m;
  for (const auto& t : mesh.triangles) {
    const Vector3d& a = mesh.vertices_m[t[0]];
    const Vector3d u = mesh.vertices_m[t[1]] - a, v = mesh.vertices_m[t[2]] - a;
    const double reach_m = std::max(u.norm(), v.norm());
    if ((a - fruit.centre_m).norm() > fruit.radius_m + reach_m + kFar_m) continue;
    for (int i = 0; i <= kCells; ++i) {
      for (int j = 0; i + j <= kCells; ++j) {
        const Vector3d p =
            a + (static_cast<double>(i) / kCells) * u + (static_cast<double>(j) / kCells) * v;
        deepest = std::max(deepest, fruit.depth_m(p, kFar_m));
      }
    }
  }
  return deepest;
}

}  // namespace

double plants_in_fruits_m(const Scene& scene) {
  std::vector<HangingFruit> fruits;
  for (const Instance& instance : scene.instances) {
    if (instance.is_specimen) fruits.push_back(fruit_of(scene, instance));
  }
  double deepest = -kFar_m;
  for (const Instance& instance : scene.instances) {
    if (instance.category != "strawberry plant") continue;
    const Mesh mesh = mesh_in_world(scene, instance);
    for (const HangingFruit& fruit : fruits)
      deepest = std::max(deepest, sheet_depth_m(mesh, fruit));
  }
  return deepest;
}

double sepals_in_fruits_m(const Scene& scene) {
  double deepest = -kFar_m;
  for (const Instance& calyx : scene.instances) {
    if (calyx.category != "calyx") continue;
    const Mesh mesh = mesh_in_world(scene, calyx);
    for (const Instance& fruit : scene.instances) {
      // A fruit's own calyx comes after it.
      if (!fruit.is_specimen || fruit.id + 1 == calyx.id) continue;
      deepest = std::max(deepest, sheet_depth_m(mesh, fruit_of(scene, fruit)));
    }
  }
  return deepest;
}

}  // namespace cousin
