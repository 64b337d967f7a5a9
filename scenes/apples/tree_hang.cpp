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

/// The branch's stem that an axis it carries is; -1: none, it goes with the branch.
int stem_of_axis(const HangingBranch& b, int axis) {
  if (axis == b.axis) return 0;
  const auto at = std::find(b.spurs.begin(), b.spurs.end(), axis);
  return at == b.spurs.end() ? -1 : 1 + static_cast<int>(at - b.spurs.begin());
}

BranchPlace place_on(const AppleTree& tree, const HangingBranch& b, int axis, double share) {
  const int stem = stem_of_axis(b, axis);
  if (stem >= 0) return {0, stem, share};
  return {0, 0, tree.wood[static_cast<std::size_t>(axis)].parent_share};
}

/// Moves what a branch carries to where it came to hang. @return way of its tip
double apply(AppleTree& tree, const HangingBranch& b) {
  const BentPlant& bent = b.rest;
  for (std::size_t k = 0; k < b.fruits.size(); ++k) {
    Pose& pose = tree.fruits[static_cast<std::size_t>(b.fruits[k])].tree_from_fruit;
    pose = bent_from_unbent(b.plant, bent, b.plant.loads[k].stem, 1) * pose;
  }
  // A point, and a turn, that go with an axis' share.
  const auto moved = [&](int axis, double share, const Vector3d& p) {
    const BranchPlace at = place_on(tree, b, axis, share);
    return bend_m(b.plant, bent, at.stem, at.share, p);
  };
  for (LeafPlace& leaf : tree.leaves) {
    const WoodAxis& axis = tree.wood[static_cast<std::size_t>(leaf.axis)];
    if (leaf.axis != b.axis && axis.parent != b.axis) continue;
    const BranchPlace at = place_on(tree, b, leaf.axis, leaf.share);
    Pose& pose = leaf.tree_from_leaf;
    pose.translation_m = moved(leaf.axis, leaf.share, pose.translation_m);
    pose.rotation =
        (bent_from_unbent(b.plant, bent, at.stem, at.share).rotation * pose.rotation).normalized();
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

BranchPlace place_on_branch(const AppleTree& tree, int axis, double share) {
  const int parent = tree.wood[static_cast<std::size_t>(axis)].parent;
  for (std::size_t i = 0; i < tree.branches.size(); ++i) {
    const HangingBranch& b = tree.branches[i];
    if (axis != b.axis && parent != b.axis) continue;
    BranchPlace place = place_on(tree, b, axis, share);
    place.branch = static_cast<int>(i);
    return place;
  }
  return {};
}

BranchPlace place_on_branch(const AppleTree& tree, const FruitPlace& fruit) {
  BranchPlace place = place_on_branch(tree, fruit.axis, 1);
  if (place.branch < 0 || fruit.load < 0) return {};
  const HangingBranch& b = tree.branches[static_cast<std::size_t>(place.branch)];
  place.stem = b.plant.loads[static_cast<std::size_t>(fruit.load)].stem;
  place.share = 1;
  return place;
}

std::vector<SagResult> settle_branches(const std::vector<HangingBranch>& branches) {
  std::vector<SagResult> results(branches.size());
  tbb::parallel_for(std::size_t{0}, branches.size(),
                    [&](std::size_t i) { results[i] = sag(branches[i].plant); });
  return results;
}

void hang_fruits(AppleTree& tree, const OrchardConfig& config,
                 const std::vector<FruitModel>& models, bool bends, const BranchSettler& settle) {
  if (bends) tree.branches = hanging_branches(tree, config, models);
  const std::vector<SagResult> sags = settle(tree.branches);
  tree.rest.branches = static_cast<int>(tree.branches.size());
  tree.rest.is_bent = bends;
  for (std::size_t i = 0; i < tree.branches.size(); ++i) {
    HangingBranch& b = tree.branches[i];
    const SagResult& sag = sags.at(i);
    if (sag.status == PlantStatus::not_built) {
      tree.rest.is_bent = false;
      tree.branches.clear();
      break;
    }
    if (sag.status == PlantStatus::broke || sag.status == PlantStatus::engine_warning) {
      throw std::invalid_argument(
          "apples: a branch at " +
          std::to_string(tree.wood[static_cast<std::size_t>(b.axis)].line.points_m[0].z()) +
          " m under " + std::to_string(b.fruits.size()) + " fruits: " +
          std::string(to_string(sag.status)) + ", stress " + std::to_string(sag.strain.ratio) +
          " times orchard.branch.strength_pa " + sag.first_warning);
    }
    b.rest = sag.bent;
    for (std::size_t k = 0; k < b.fruits.size(); ++k)
      tree.fruits[static_cast<std::size_t>(b.fruits[k])].load = static_cast<int>(k);
    tree.rest.not_at_rest += sag.status == PlantStatus::not_at_rest;
    tree.rest.stress_ratio = std::max(tree.rest.stress_ratio, sag.strain.ratio);
    tree.rest.sag_m = std::max(tree.rest.sag_m, apply(tree, b));
  }
  part_overlaps(tree, models);
}

}  // namespace cousin
