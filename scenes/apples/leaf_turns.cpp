#include "scenes/apples/leaf_turns.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace cousin {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kMostLeaves = 14;  // turned for one view

/// A leaf that may be turned, and how.
struct Turn {
  std::size_t place = 0;  ///< into scene.instances
  const PlantModel* model = nullptr;
  Pose rest;
  Eigen::Quaterniond turned;
  double order = 0;  ///< the least is turned first
};

/// Middle of a leaf's blade, in its frame.
Vector3d middle_m(const PlantModel& leaf) {
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& p : leaf.model.mesh.vertices_m) sum += p;
  return sum / static_cast<double>(leaf.model.mesh.vertices_m.size());
}

Pose pose_at(const Turn& turn, double share) {
  return {turn.rest.rotation.slerp(std::clamp(share, 0.0, 1.0), turn.turned),
          turn.rest.translation_m};
}

/// The line of sight to a target.
struct Sight {
  Vector3d eye_m, centre_m;
  double radius_m = 0;
  Vector3d towards_eye() const { return (eye_m - centre_m).normalized(); }
  double length_m() const { return (eye_m - centre_m).norm(); }
};

/// A leaf from beside the line of sight, laid across it with its face to the eye.
bool lay_before(Turn& turn, const Sight& sight, const Vector3d& middle) {
  const Vector3d base = turn.rest.translation_m, to_eye = sight.towards_eye();
  const double reach_m = middle.norm();
  const double along = std::clamp((base - sight.centre_m).dot(to_eye), sight.radius_m + 0.012,
                                  sight.length_m() - 0.05);
  const Vector3d on_line = sight.centre_m + along * to_eye;
  Vector3d side = base - on_line;
  side -= side.dot(to_eye) * to_eye;
  const double off_m = side.norm();
  // Its tip must come at least to the disk's rim, and its base stand beside the disk.
  if (off_m < 0.3 * sight.radius_m || off_m > sight.radius_m + 1.3 * reach_m) return false;
  if ((base - on_line).norm() > sight.radius_m + 1.6 * reach_m) return false;
  const Vector3d x = (on_line - base).normalized();
  Vector3d z = to_eye - to_eye.dot(x) * x;
  if (z.norm() < 0.2) return false;
  z.normalize();
  if (z.dot(turn.rest.rotation * Vector3d::UnitZ()) < 0) z = -z;
  Eigen::Matrix3d axes;
  axes << x, z.cross(x), z;
  turn.turned = Eigen::Quaterniond(axes).normalized();
  turn.order = std::abs((base - on_line).norm() - reach_m);
  return true;
}

/// A leaf that stands in the cone to the target, turned away from its axis.
bool turn_aside(Turn& turn, const Sight& sight, const Vector3d& middle) {
  const Vector3d to_eye = sight.towards_eye(), at = turn.rest * middle;
  const double along = (at - sight.centre_m).dot(to_eye);
  if (along < 0 || along > sight.length_m()) return false;
  const double cone_m = sight.radius_m * (1 - along / sight.length_m()) + 0.06;
  const Vector3d out = at - sight.centre_m - along * to_eye;
  if (out.norm() > cone_m) return false;
  const Vector3d base = turn.rest.translation_m;
  Vector3d away = base - sight.centre_m - (base - sight.centre_m).dot(to_eye) * to_eye;
  away = away.norm() > 0.01 ? Vector3d(away.normalized() + 0.3 * out.normalized())
                            : Vector3d(out + 0.01 * Vector3d::UnitZ());
  turn.turned = Eigen::Quaterniond::FromTwoVectors(turn.rest.rotation * Vector3d::UnitX(),
                                                   away.normalized()) *
                turn.rest.rotation;
  turn.order = out.norm();
  return true;
}

std::vector<Turn> turns_for(const Scene& scene, const TurnableLeaves& leaves, const Sight& sight,
                            bool hides) {
  std::vector<Turn> turns;
  for (std::size_t i = 0; i < leaves.grown.tree.leaves.size(); ++i) {
    Turn turn;
    turn.place = leaves.first + i;
    if (leaves.turned.contains(turn.place)) continue;
    const auto variant = static_cast<std::size_t>(leaves.grown.tree.leaves[i].variant);
    turn.model = &leaves.grown.leaves[variant];
    turn.rest = scene.instances[turn.place].world_from_object;
    if ((turn.rest.translation_m - sight.centre_m).norm() > sight.length_m() + 0.2) continue;
    const Vector3d middle = middle_m(*turn.model);
    if (!(hides ? lay_before(turn, sight, middle) : turn_aside(turn, sight, middle))) continue;
    if (leaves.room.is_free(*turn.model, pose_at(turn, 1))) turns.push_back(turn);
  }
  std::stable_sort(turns.begin(), turns.end(),
                   [](const Turn& a, const Turn& b) { return a.order < b.order; });
  if (turns.size() > kMostLeaves) turns.resize(kMostLeaves);
  return turns;
}

}  // namespace

MovedLeaves turn_leaves(const Scene& scene, const TurnableLeaves& leaves, std::size_t target,
                        const TrueView& view, double reach_m, double wanted) {
  const VisibleShare before(scene, target, reach_m);
  const double rest = before.seen(view);
  const Sight sight{centre_in_world_m(view.camera_from_world), before.centre_in_world_m(),
                    before.radius_m()};
  const std::vector<Turn> turns = turns_for(scene, leaves, sight, rest > wanted);
  std::vector<MovableLeaf> movable;
  for (const Turn& turn : turns) {
    movable.push_back({turn.place, [&turn](double share) { return pose_at(turn, share); },
                       [&leaves, &turn](double share) {
                         return leaves.room.is_free(*turn.model, pose_at(turn, share));
                       }});
  }
  return move_leaves(scene, movable, target, view, reach_m, wanted);
}

}  // namespace cousin
