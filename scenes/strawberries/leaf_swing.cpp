#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "scenes/strawberries/target_views.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kMostLeaves = 12;  // swung for one view

/// A leaf that may be swung, and how.
struct Swing {
  std::size_t place = 0;  ///< into scene.instances
  Pose rest;
  Eigen::Quaterniond turned;
  double order = 0;  ///< the least is swung first
};

Pose pose_at(const Swing& swing, double share) {
  return {swing.rest.rotation.slerp(std::clamp(share, 0.0, 1.0), swing.turned),
          swing.rest.translation_m};
}

/// The line of sight to a target.
struct Sight {
  Vector3d eye_m, centre_m;
  double radius_m = 0;
  Vector3d towards_eye() const { return (eye_m - centre_m).normalized(); }
  double length_m() const { return (eye_m - centre_m).norm(); }
};

/// The nearest point to a target on its line of sight that the middle of a leaf's blades can come
/// to: at `reach_m` from its base.
std::optional<Vector3d> point_before(const Sight& sight, const Vector3d& base_m, double reach_m) {
  const Vector3d to_eye = sight.towards_eye(), from_base = sight.centre_m - base_m;
  const double b = from_base.dot(to_eye);
  const double root = b * b - from_base.squaredNorm() + reach_m * reach_m;
  if (root < 0) return {};
  for (const double along : {-b - std::sqrt(root), -b + std::sqrt(root)}) {
    if (along > sight.radius_m + 0.01 && along < sight.length_m() - 0.08)
      return sight.centre_m + along * to_eye;
  }
  return {};
}

bool swing_before(Swing& swing, const Sight& sight, const Vector3d& blade_m) {
  const Vector3d base_m = swing.rest.translation_m;
  const std::optional<Vector3d> point_m = point_before(sight, base_m, blade_m.norm());
  if (!point_m) return false;
  const auto turn =
      Eigen::Quaterniond::FromTwoVectors(swing.rest.rotation * blade_m, *point_m - base_m);
  swing.turned = turn * swing.rest.rotation;
  swing.order = Eigen::AngleAxisd(turn).angle();
  constexpr double kMost_rad = 1.4;
  return swing.order < kMost_rad;
}

/// A leaf that stands before the target, swung up and to its own side.
bool swing_aside(Swing& swing, const Sight& sight, const Vector3d& blade_m) {
  const Vector3d to_eye = sight.towards_eye(), base_m = swing.rest.translation_m;
  const Vector3d at_m = swing.rest * blade_m;
  const double along = (at_m - sight.centre_m).dot(to_eye);
  constexpr double kBlade_m = 0.09;
  if (along < 0 || along > sight.length_m()) return false;
  const Vector3d off = at_m - sight.centre_m - along * to_eye;
  if (off.norm() > sight.radius_m + kBlade_m) return false;
  const double side = off.y() + 0.5 * (base_m - sight.centre_m).y() < 0 ? -1 : 1;
  const Vector3d to = (at_m - base_m).normalized() + Vector3d(0, 0.9 * side, 0.8);
  swing.turned = Eigen::Quaterniond::FromTwoVectors(at_m - base_m, to) * swing.rest.rotation;
  swing.order = off.norm();
  return true;
}

bool is_free(const Scene& scene, const TrussLeafRoom& room, const Swing& swing, double share) {
  const auto model = static_cast<std::size_t>(scene.instances[swing.place].model);
  return room.is_free(scene.models[model].mesh, pose_at(swing, share));
}

std::vector<Swing> swings_for(const Scene& scene, const SwingingLeaves& leaves, const Sight& sight,
                              bool hides) {
  std::vector<Swing> swings;
  for (const LoneLeaf& leaf : leaves.all) {
    if (leaves.swung.contains(leaf.place)) continue;
    Swing swing;
    swing.place = leaf.place;
    swing.rest = scene.instances[leaf.place].world_from_object;
    const bool helps =
        hides ? swing_before(swing, sight, leaf.blade_m) : swing_aside(swing, sight, leaf.blade_m);
    if (helps && is_free(scene, leaves.room, swing, 1)) swings.push_back(swing);
  }
  std::stable_sort(swings.begin(), swings.end(),
                   [](const Swing& a, const Swing& b) { return a.order < b.order; });
  if (swings.size() > kMostLeaves) swings.resize(kMostLeaves);
  return swings;
}

}  // namespace

MovedLeaves swing_leaves(const Scene& scene, const SwingingLeaves& leaves, std::size_t target,
                         const TrueView& view, double reach_m, double wanted) {
  const VisibleShare before(scene, target, reach_m);
  const Sight sight{centre_in_world_m(view.camera_from_world), before.centre_in_world_m(),
                    before.radius_m()};
  const std::vector<Swing> swings = swings_for(scene, leaves, sight, before.seen(view) > wanted);
  std::vector<MovableLeaf> movable;
  for (const Swing& swing : swings) {
    movable.push_back({swing.place, [&swing](double share) { return pose_at(swing, share); },
                       [&](double share) { return is_free(scene, leaves.room, swing, share); }});
  }
  return move_leaves(scene, movable, target, view, reach_m, wanted);
}

}  // namespace cousin
