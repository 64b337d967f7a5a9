#include "sim/render/leaf_area_truth.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/render/point_in_view.h"
#include "sim/render/ray_scene_impl.h"
#include "sim/render/sample_points.h"
#include "sim/truth/specimens.h"

namespace cousin {
namespace {

bool is_leaf(const Scene& scene, const Instance& instance, std::size_t triangle) {
  const ObjectModel& model = scene.models[static_cast<std::size_t>(instance.model)];
  int material = instance.material;
  if (!instance.part_materials.empty() && !model.triangle_part.empty())
    material = instance.part_materials[model.triangle_part[triangle]];
  return scene.materials[static_cast<std::size_t>(material)].kind == SurfaceKind::leaf;
}

/// Points of equal shares of the leaf area, and that area.
struct LeafPoints {
  struct Point {
    std::size_t place = 0;  ///< into Scene::instances
    Eigen::Vector3d in_object_m;
  };
  double area_m2 = 0;
  std::vector<Point> points;
};

const Mesh& mesh_of(const Scene& scene, std::size_t place) {
  return scene.models[static_cast<std::size_t>(scene.instances[place].model)].mesh;
}

LeafPoints leaf_points(const Scene& scene, const std::vector<std::size_t>& places, int points) {
  struct Triangle {
    std::size_t place = 0, index = 0;
  };
  std::vector<Triangle> triangles;
  std::vector<double> sum_m2;  // of the areas so far
  LeafPoints leaf;
  for (const std::size_t place : places) {
    const Mesh& mesh = mesh_of(scene, place);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      if (!is_leaf(scene, scene.instances[place], t)) continue;
      const auto& [a, b, c] = mesh.triangles[t];
      const Eigen::Vector3d& origin = mesh.vertices_m[a];
      leaf.area_m2 += 0.5 * (mesh.vertices_m[b] - origin).cross(mesh.vertices_m[c] - origin).norm();
      triangles.push_back({place, t});
      sum_m2.push_back(leaf.area_m2);
    }
  }
  if (!(leaf.area_m2 > 0)) return leaf;
  for (int i = 0; i < points; ++i) {
    const auto k = static_cast<std::uint64_t>(i);
    const Eigen::Vector2d shift = unit_pair(hash64(3 * k)).cast<double>();
    Eigen::Vector2d place = unit_pair(hash64(3 * k + 1)).cast<double>();
    const double at_m2 = leaf.area_m2 * (i + shift.x()) / points;
    const auto found = std::upper_bound(sum_m2.begin(), sum_m2.end(), at_m2);
    const auto t = std::min(static_cast<std::size_t>(found - sum_m2.begin()), sum_m2.size() - 1);
    if (place.sum() > 1) place = Eigen::Vector2d::Ones() - place;
    const Mesh& mesh = mesh_of(scene, triangles[t].place);
    const auto& [a, b, c] = mesh.triangles[triangles[t].index];
    const Eigen::Vector3d& origin = mesh.vertices_m[a];
    leaf.points.push_back({triangles[t].place, origin + place.x() * (mesh.vertices_m[b] - origin) +
                                                   place.y() * (mesh.vertices_m[c] - origin)});
  }
  return leaf;
}

}  // namespace

std::vector<LeafAreaView> view_leaf_areas(const RayScene& rays, const Scene& scene,
                                          const TrueView& view, int points) {
  if (scene.instances.size() != rays.impl().geometries.size()) {
    throw std::invalid_argument("leaf area: the scene \"" + scene.name +
                                "\" is not the one of the rays");
  }
  if (points < 1)
    throw std::invalid_argument("leaf area: " + std::to_string(points) + " points; at least 1");
  const std::vector<const Instance*> order = specimens_of(scene);
  std::vector<LeafAreaView> areas(order.size());
  tbb::parallel_for(std::size_t{0}, order.size(), [&](std::size_t i) {
    const LeafPoints leaf = leaf_points(scene, places_of(scene, *order[i]), points);
    LeafAreaView& area = areas[i];
    area.instance = order[i]->id;
    area.whole_m2 = leaf.area_m2;
    for (const LeafPoints::Point& point : leaf.points) {
      const auto seen = image_of(view, scene.instances[point.place], point.in_object_m);
      area.is_seen.push_back(seen && is_inside(view.camera, seen->pixel_px) &&
                             is_in_sight(rays, *seen, point.place, 0));
    }
  });
  return areas;
}

}  // namespace cousin
