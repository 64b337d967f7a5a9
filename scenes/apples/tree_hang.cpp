#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "scenes/apples/tree_overlaps.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

bool bears(const AppleTree& tree, int axis) {
  return std::any_of(tree.fruits.begin(), tree.fruits.end(),
                     [&](const FruitPlace& f) { return f.axis == axis; });
}

/// One branch with what hangs on it, as physics bends it.
struct HangingBranch {
  int axis = 0;
  std::vector<int> spurs;    ///< that bear; stem 1 + k of the plant
  std::vector<int> fruits;   ///< load k, on stem 1 + spurs + k
  std::vector<int> carried;  ///< axes that are moved with it, the spurs that bear among them
  BendingPlant plant;
  SagResult sag;
};

BendingStem stem_of(const CentreLine& line, const OrchardConfig::Branch& c, int segments) {
  BendingStem stem;
  stem.points_m = line.points_m;
  stem.radii_m = line.radii_m;
  stem.young_modulus_pa = c.young_modulus_pa;
  stem.strength_pa = c.strength_pa;
  stem.density_kg_m3 = c.density_kg_m3;
  stem.damping_time_s = c.damping_time_s;
  stem.segments = segments;
  return stem;
}

/// The end of a spur that a stalk turns on: as stiff as the configuration says.
BendingStem knuckle_of(const Vector3d& from_m, const Vector3d& to_m, const OrchardConfig& c) {
  constexpr double kRadius_m = 0.0015;
  BendingStem stem;
  stem.points_m = {from_m, to_m};
  stem.radii_m = {kRadius_m, kRadius_m};
  stem.young_modulus_pa = c.fruit.bourse_stiffness_n_m * (to_m - from_m).norm() /
                          (std::numbers::pi / 4 * std::pow(kRadius_m, 4));
  stem.density_kg_m3 = c.branch.density_kg_m3;
  stem.damping_time_s = c.branch.damping_time_s;
  stem.segments = 1;
  return stem;
}

std::vector<HangingBranch> hanging_branches(const AppleTree& tree, const OrchardConfig& config,
                                            const std::vector<FruitModel>& models) {
  std::vector<HangingBranch> result;
  for (std::size_t b = 0; b < tree.wood.size(); ++b) {
    if (tree.wood[b].kind != WoodKind::branch) continue;
    HangingBranch one;
    one.axis = static_cast<int>(b);
    for (std::size_t i = 0; i < tree.wood.size(); ++i) {
      if (tree.wood[i].parent == one.axis) one.carried.push_back(static_cast<int>(i));
    }
    one.plant.stems.push_back(stem_of(tree.wood[b].line, config.branch, 10));
    for (const int spur : one.carried) {
      if (!bears(tree, spur)) continue;
      one.spurs.push_back(spur);
      const WoodAxis& axis = tree.wood[static_cast<std::size_t>(spur)];
      BendingStem stem = stem_of(axis.line, config.branch, 2);
      stem.parent = 0;
      stem.parent_share = axis.parent_share;
      one.plant.stems.push_back(std::move(stem));
    }
    if (one.spurs.empty()) continue;
    for (std::size_t f = 0; f < tree.fruits.size(); ++f) {
      const FruitPlace& fruit = tree.fruits[f];
      const auto spur = std::find(one.spurs.begin(), one.spurs.end(), fruit.axis);
      if (spur == one.spurs.end()) continue;
      const FruitModel& model = models[static_cast<std::size_t>(fruit.variant)];
      const Vector3d from = tree.wood[static_cast<std::size_t>(fruit.axis)].line.points_m.back();
      const Vector3d down = -(fruit.tree_from_fruit.rotation * Vector3d::UnitZ());
      BendingStem knuckle = knuckle_of(from, from + 0.004 * down, config);
      knuckle.parent = 1 + static_cast<int>(spur - one.spurs.begin());
      BendingLoad load;
      load.stem = static_cast<int>(one.plant.stems.size());
      load.mass_kg = fruit.mass_kg;
      load.centroid_m = fruit.tree_from_fruit.translation_m;
      load.hulls = {model.hull};
      load.world_from_hulls = fruit.tree_from_fruit.rotation;
      one.plant.stems.push_back(std::move(knuckle));
      one.plant.loads.push_back(std::move(load));
      one.fruits.push_back(static_cast<int>(f));
    }
    result.push_back(std::move(one));
  }
  return result;
}

/// Moves what a branch carries to where it came to hang. @return way of its tip
double apply(AppleTree& tree, const HangingBranch& b) {
  const BentPlant& bent = b.sag.bent;
  for (std::size_t k = 0; k < b.fruits.size(); ++k) {
    Pose& pose = tree.fruits[static_cast<std::size_t>(b.fruits[k])].tree_from_fruit;
    pose = bent_from_unbent(b.plant, bent, b.plant.loads[k].stem, 1) * pose;
  }
  const auto stem_of_axis = [&](int axis) {
    const auto at = std::find(b.spurs.begin(), b.spurs.end(), axis);
    return at == b.spurs.end() ? -1 : 1 + static_cast<int>(at - b.spurs.begin());
  };
  // A point, and a turn, that go with an axis' share.
  const auto moved = [&](int axis, double share, const Vector3d& p) {
    if (axis == b.axis) return bend_m(b.plant, bent, 0, share, p);
    const int stem = stem_of_axis(axis);
    if (stem > 0) return bend_m(b.plant, bent, stem, share, p);
    return bend_m(b.plant, bent, 0, tree.wood[static_cast<std::size_t>(axis)].parent_share, p);
  };
  for (LeafPlace& leaf : tree.leaves) {
    const WoodAxis& axis = tree.wood[static_cast<std::size_t>(leaf.axis)];
    if (leaf.axis != b.axis && axis.parent != b.axis) continue;
    const int stem = leaf.axis == b.axis ? 0 : std::max(0, stem_of_axis(leaf.axis));
    const double share = stem > 0 || leaf.axis == b.axis ? leaf.share : axis.parent_share;
    Pose& pose = leaf.tree_from_leaf;
    pose.translation_m = moved(leaf.axis, leaf.share, pose.translation_m);
    pose.rotation =
        (bent_from_unbent(b.plant, bent, stem, share).rotation * pose.rotation).normalized();
  }
  const Vector3d tip = tree.wood[static_cast<std::size_t>(b.axis)].line.points_m.back();
  std::vector<int> axes = b.carried;
  axes.push_back(b.axis);
  for (const int axis : axes) {
    CentreLine& line = tree.wood[static_cast<std::size_t>(axis)].line;
    const double whole_m = length_m(line);
    double along_m = 0;
    Vector3d before = line.points_m.front();
    for (Vector3d& p : line.points_m) {
      along_m += (p - before).norm();
      before = p;
      p = moved(axis, along_m / whole_m, p);
    }
  }
  return (tree.wood[static_cast<std::size_t>(b.axis)].line.points_m.back() - tip).norm();
}

}  // namespace

void hang_fruits(AppleTree& tree, const OrchardConfig& config,
                 const std::vector<FruitModel>& models, bool bends) {
  std::vector<HangingBranch> branches;
  if (bends) branches = hanging_branches(tree, config, models);
  tbb::parallel_for(std::size_t{0}, branches.size(),
                    [&](std::size_t i) { branches[i].sag = sag(branches[i].plant); });
  tree.rest.branches = static_cast<int>(branches.size());
  tree.rest.is_bent = bends;
  for (const HangingBranch& b : branches) {
    const PlantStatus status = b.sag.status;
    if (status == PlantStatus::not_built) {
      tree.rest.is_bent = false;
      break;
    }
    if (status == PlantStatus::broke || status == PlantStatus::engine_warning) {
      throw std::invalid_argument(
          "apples: a branch at " +
          std::to_string(tree.wood[static_cast<std::size_t>(b.axis)].line.points_m[0].z()) +
          " m under " + std::to_string(b.fruits.size()) + " fruits: " +
          std::string(to_string(status)) + ", stress " + std::to_string(b.sag.strain.ratio) +
          " times orchard.branch.strength_pa " + b.sag.first_warning);
    }
    tree.rest.not_at_rest += status == PlantStatus::not_at_rest;
    tree.rest.stress_ratio = std::max(tree.rest.stress_ratio, b.sag.strain.ratio);
    tree.rest.sag_m = std::max(tree.rest.sag_m, apply(tree, b));
  }
  part_overlaps(tree, models);
}

}  // namespace cousin
