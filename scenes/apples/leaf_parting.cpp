#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <map>

#include "scenes/apples/placed_fruit.h"
#include "sim/geometry/surface_crossing.h"

namespace cousin {
namespace {

using Eigen::Vector3d;
using Box = Eigen::AlignedBox3d;
using Triangle = std::array<Vector3d, 3>;

/// A blade in its place.
struct PlacedBlade {
  Box box;
  std::vector<Triangle> triangles;
  std::vector<Box> boxes;
};

PlacedBlade place_blade(const PlantModel& leaf, const Pose& tree_from_leaf) {
  PlacedBlade blade;
  std::vector<Vector3d> points;
  for (const Vector3d& p : leaf.model.mesh.vertices_m) points.emplace_back(tree_from_leaf * p);
  for (std::size_t t = 0; t < leaf.model.mesh.triangles.size(); ++t) {
    if (leaf.part_looks[leaf.model.triangle_part[t]] != kAppleBladeLook) continue;
    const auto& [a, b, c] = leaf.model.mesh.triangles[t];
    blade.triangles.push_back({points[a], points[b], points[c]});
    Box box(points[a]);
    box.extend(points[b]);
    box.extend(points[c]);
    blade.boxes.push_back(box);
    blade.box.extend(box);
  }
  return blade;
}

bool cross(const PlacedBlade& a, const PlacedBlade& b) {
  if (!a.box.intersects(b.box)) return false;
  std::vector<std::size_t> near;
  for (std::size_t i = 0; i < b.boxes.size(); ++i) {
    if (b.boxes[i].intersects(a.box)) near.push_back(i);
  }
  for (std::size_t k = 0; k < a.boxes.size(); ++k) {
    if (!a.boxes[k].intersects(b.box)) continue;
    for (const std::size_t i : near) {
      if (a.boxes[k].intersects(b.boxes[i]) && triangles_meet(a.triangles[k], b.triangles[i]))
        return true;
    }
  }
  return false;
}

/// The place that a leaf has and those about it, nearest first.
std::vector<Pose> places_about(const Pose& rest) {
  std::vector<Pose> places = {rest};
  for (const double turn : {0.2, 0.4, 0.65, 0.95}) {
    for (const Vector3d& axis :
         {Vector3d(0, -1, 0), Vector3d(0, 1, 0), Vector3d(0, 0, 1), Vector3d(0, 0, -1),
          Vector3d(1, 0, 0), Vector3d(-1, 0, 0), Vector3d(0, -0.7, 0.7), Vector3d(0, -0.7, -0.7)}) {
      Pose turned = rest;
      turned.rotation = rest.rotation * Eigen::AngleAxisd(turn, axis.normalized());
      places.push_back(turned);
    }
  }
  return places;
}

/// Cells of space, each with the leaves whose boxes reach into it.
class LeafGrid {
 public:
  void add(const Box& box, std::size_t leaf) {
    visit(box, [&](const Cell& cell) { cells_[cell].push_back(leaf); });
  }
  template <class Test>
  bool any_of(const Box& box, const Test& test) const {
    bool found = false;
    visit(box, [&](const Cell& cell) {
      const auto at = cells_.find(cell);
      if (found || at == cells_.end()) return;
      found = std::any_of(at->second.begin(), at->second.end(), test);
    });
    return found;
  }

 private:
  using Cell = std::array<int, 3>;
  static constexpr double kCell_m = 0.08;

  template <class Visit>
  static void visit(const Box& box, const Visit& found) {
    const Eigen::Vector3i low = (box.min() / kCell_m).array().floor().cast<int>(),
                          high = (box.max() / kCell_m).array().floor().cast<int>();
    for (int z = low.z(); z <= high.z(); ++z) {
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int x = low.x(); x <= high.x(); ++x) found({x, y, z});
      }
    }
  }

  std::map<Cell, std::vector<std::size_t>> cells_;
};

/// Leaves in their places, and which of them are kept.
class LeafParting {
 public:
  LeafParting(AppleTree& tree, const std::vector<FruitModel>& fruits,
              const std::vector<PlantModel>& leaves, const std::vector<PlantModel>& coarse)
      : tree_(tree),
        leaves_(leaves),
        coarse_(coarse),
        room_(tree, fruits),
        blades_(tree.leaves.size()),
        is_kept_(tree.leaves.size(), 1) {
    tbb::parallel_for(std::size_t{0}, blades_.size(), [&](std::size_t i) {
      blades_[i] = place_blade(model(i), tree_.leaves[i].tree_from_leaf);
    });
  }

  /// Each branch by itself: leaves of one that cross.
  void part_in_branches() {
    std::map<int, std::vector<std::size_t>> groups;
    for (std::size_t i = 0; i < tree_.leaves.size(); ++i) groups[branch_of(i)].push_back(i);
    std::vector<std::vector<std::size_t>> lists;
    for (auto& [branch, list] : groups) lists.push_back(std::move(list));
    tbb::parallel_for(std::size_t{0}, lists.size(), [&](std::size_t k) {
      LeafGrid grid;
      for (const std::size_t i : lists[k]) find_place(i, grid);
    });
  }

  /// Then those that cross leaves of another branch.
  void part_between_branches() {
    LeafGrid all;
    for (std::size_t i = 0; i < blades_.size(); ++i) {
      if (is_kept_[i]) all.add(blades_[i].box, i);
    }
    std::vector<char> crosses(blades_.size(), 0);
    tbb::parallel_for(std::size_t{0}, blades_.size(), [&](std::size_t i) {
      crosses[i] = is_kept_[i] && all.any_of(blades_[i].box, [&](std::size_t k) {
        return k < i && branch_of(k) != branch_of(i) && cross(blades_[i], blades_[k]);
      });
    });
    LeafGrid grid;
    for (std::size_t i = 0; i < blades_.size(); ++i) {
      if (is_kept_[i] && !crosses[i]) grid.add(blades_[i].box, i);
    }
    for (std::size_t i = 0; i < blades_.size(); ++i) {
      if (crosses[i]) find_place(i, grid);
    }
  }

  void take_off() {
    std::size_t next = 0;
    for (std::size_t i = 0; i < tree_.leaves.size(); ++i) {
      if (is_kept_[i]) tree_.leaves[next++] = tree_.leaves[i];
    }
    tree_.leaves.resize(next);
  }

 private:
  const PlantModel& fine(std::size_t leaf) const {
    return leaves_[static_cast<std::size_t>(tree_.leaves[leaf].variant)];
  }
  const PlantModel& model(std::size_t leaf) const {
    return coarse_[static_cast<std::size_t>(tree_.leaves[leaf].variant)];
  }
  int branch_of(std::size_t leaf) const {
    const int axis = tree_.leaves[leaf].axis;
    const WoodAxis& wood = tree_.wood[static_cast<std::size_t>(axis)];
    return wood.kind == WoodKind::spur || wood.kind == WoodKind::shoot ? wood.parent : axis;
  }

  /// Where the leaf crosses none of the grid, to which it is added; without such a place it goes.
  void find_place(std::size_t i, LeafGrid& grid) {
    const Pose rest = tree_.leaves[i].tree_from_leaf;
    bool is_first = true;
    for (const Pose& place : places_about(rest)) {
      PlacedBlade blade = is_first ? blades_[i] : place_blade(model(i), place);
      const bool is_free = !grid.any_of(blade.box, [&](std::size_t k) {
        return cross(blade, blades_[k]);
      }) && (is_first || room_.is_free(fine(i), place));
      is_first = false;
      if (!is_free) continue;
      tree_.leaves[i].tree_from_leaf = place;
      blades_[i] = std::move(blade);
      grid.add(blades_[i].box, i);
      return;
    }
    is_kept_[i] = 0;
  }

  AppleTree& tree_;
  const std::vector<PlantModel>& leaves_;
  const std::vector<PlantModel>& coarse_;
  LeafRoom room_;
  std::vector<PlacedBlade> blades_;
  std::vector<char> is_kept_;
};

}  // namespace

void part_leaves(AppleTree& tree, const std::vector<FruitModel>& fruits,
                 const std::vector<PlantModel>& leaves, const std::vector<PlantModel>& coarse) {
  LeafParting parting(tree, fruits, leaves, coarse);
  parting.part_in_branches();
  parting.part_between_branches();
  parting.take_off();
}

}  // namespace cousin
