#include "scenes/apples/tree_overlaps.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "scenes/apples/placed_fruit.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

constexpr double kDeepest_m = 5e-4;

double overlap_m(const PlacedFruit& a, const PlacedFruit& b) {
  const Vector3d apart = a.tree_from_fruit.translation_m - b.tree_from_fruit.translation_m;
  if (apart.norm() > a.radius_m + b.radius_m) return a.radius_m + b.radius_m - apart.norm();
  double deepest = -1;
  const Pose a_from_b = a.fruit_from_tree * b.tree_from_fruit, b_from_a = inverse(a_from_b);
  for (const Vector3d& v : b.hull->vertices_m)
    deepest = std::max(deepest, a.body->depth_m(a_from_b * v, deepest));
  for (const Vector3d& v : a.hull->vertices_m)
    deepest = std::max(deepest, b.body->depth_m(b_from_a * v, deepest));
  return deepest;
}

/// Depth of wood in a fruit, by balls along its line; the wood that bears it is left out.
double overlap_m(const PlacedFruit& fruit, const WoodAxis& axis) {
  double deepest = -1;
  const CentreLine& line = axis.line;
  constexpr int kPlaces = 8;  // a piece
  for (std::size_t i = 1; i < line.points_m.size(); ++i) {
    const Vector3d middle = 0.5 * (line.points_m[i] + line.points_m[i - 1]);
    const double reach_m = fruit.radius_m + line.radii_m[i - 1] +
                           0.5 * (line.points_m[i] - line.points_m[i - 1]).norm();
    if ((middle - fruit.tree_from_fruit.translation_m).norm() > reach_m) continue;
    for (int k = 0; k <= kPlaces; ++k) {
      const double t = static_cast<double>(k) / kPlaces;
      const Vector3d p = line.points_m[i - 1] + t * (line.points_m[i] - line.points_m[i - 1]);
      const double radius_m = std::lerp(line.radii_m[i - 1], line.radii_m[i], t);
      deepest = std::max(
          deepest, fruit.body->depth_m(fruit.fruit_from_tree * p, deepest - radius_m) + radius_m);
    }
  }
  return deepest;
}

}  // namespace

void part_overlaps(AppleTree& tree, const std::vector<FruitModel>& models) {
  const FruitBodies bodies(models);
  tree.rest.deepest_m = -1;
  std::vector<FruitPlace> kept;
  std::vector<PlacedFruit> placed;
  std::vector<bool> is_bearing(tree.wood.size(), false);
  for (const FruitPlace& fruit : tree.fruits)
    is_bearing[static_cast<std::size_t>(fruit.axis)] = true;
  for (const FruitPlace& fruit : tree.fruits) {
    const PlacedFruit one = bodies.place(fruit);
    double deepest = -1;
    for (const PlacedFruit& other : placed) deepest = std::max(deepest, overlap_m(one, other));
    std::vector<std::size_t> in_the_way;
    for (std::size_t i = 0; i < tree.wood.size(); ++i) {
      WoodAxis& axis = tree.wood[i];
      if (axis.is_pruned || static_cast<int>(i) == fruit.axis) continue;
      const double depth = overlap_m(one, axis);
      const bool is_bare =
          axis.kind == WoodKind::shoot || (axis.kind == WoodKind::spur && !is_bearing[i]);
      if (is_bare && depth > kDeepest_m) {
        in_the_way.push_back(i);
      } else {
        deepest = std::max(deepest, depth);
      }
    }
    if (deepest > kDeepest_m) {
      ++tree.rest.thinned;
      continue;
    }
    for (const std::size_t i : in_the_way) tree.wood[i].is_pruned = true;
    tree.rest.deepest_m = std::max(tree.rest.deepest_m, deepest);
    placed.push_back(one);
    kept.push_back(fruit);
  }
  tree.fruits = std::move(kept);
  std::erase_if(tree.leaves, [&](const LeafPlace& leaf) {
    return tree.wood[static_cast<std::size_t>(leaf.axis)].is_pruned;
  });
}

void clear_leaves(AppleTree& tree, const std::vector<FruitModel>& fruits,
                  const std::vector<PlantModel>& leaves) {
  const LeafRoom room(tree, fruits);
  std::vector<char> is_kept(tree.leaves.size(), 1);
  tbb::parallel_for(std::size_t{0}, tree.leaves.size(), [&](std::size_t i) {
    LeafPlace& leaf = tree.leaves[i];
    const PlantModel& model = leaves[static_cast<std::size_t>(leaf.variant)];
    const Pose rest = leaf.tree_from_leaf;
    if (room.is_free(model, rest)) return;
    // Swung sideways and lifted, nearest to its own place first.
    for (const double turn : {0.35, 0.7, 1.05, 1.4}) {
      for (const Vector3d& axis : {Vector3d(0, -1, 0), Vector3d(0, 0, 1), Vector3d(0, 0, -1),
                                   Vector3d(0, -0.7, 0.7), Vector3d(0, -0.7, -0.7)}) {
        Pose turned = rest;
        turned.rotation = rest.rotation * Eigen::AngleAxisd(turn, axis.normalized());
        if (!room.is_free(model, turned)) continue;
        leaf.tree_from_leaf = turned;
        return;
      }
    }
    is_kept[i] = 0;
  });
  std::size_t next = 0;
  for (std::size_t i = 0; i < tree.leaves.size(); ++i) {
    if (is_kept[i]) tree.leaves[next++] = tree.leaves[i];
  }
  tree.leaves.resize(next);
}

}  // namespace cousin
