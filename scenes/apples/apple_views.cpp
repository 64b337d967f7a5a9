#include "scenes/apples/apple_views.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "sim/geometry/share_search.h"
#include "sim/render/visible_share.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

constexpr double kWithin = 0.03;      // of the share asked for: met
constexpr int kStarts = 32;           // views that are drawn for one
constexpr int kSide_px = 96;          // across the target where its share is counted
constexpr double kFromLens_m = 0.03;  // nothing stands nearer to the lens

/// A camera about a target: azimuth, pitch (looking down), distance.
using Place = Eigen::VectorXd;

struct Range {
  double low = 0, high = 0;
};

Range pitch_range(const ApplesSceneConfig& config, int view) {
  const auto& v = config.orchard.views;
  const std::array<const std::vector<double>*, 3> ranges = {&v.level_rad, &v.up_rad, &v.down_rad};
  const int kind = config.look == "level"  ? 0
                   : config.look == "up"   ? 1
                   : config.look == "down" ? 2
                                           : view % 3;
  const std::vector<double>& range = *ranges[static_cast<std::size_t>(kind)];
  return {range[0], range[1]};
}

Vector3d eye_m(const Vector3d& target_m, const Place& place) {
  const double a = place[0], p = place[1];
  return target_m +
         place[2] * Vector3d(std::cos(p) * std::cos(a), std::cos(p) * std::sin(a), std::sin(p));
}

std::vector<Place> draw_places(const ApplesSceneConfig& config, int view, const Rng& rng) {
  const Range pitch = pitch_range(config, view);
  std::vector<Place> places;
  for (int k = 0; k < kStarts; ++k) {
    Rng own = rng.fork(static_cast<std::uint64_t>(k));
    Place place(3);
    // The photographer stands in the alley on the side of -y.
    place[0] = -0.5 * std::numbers::pi + config.orchard.views.azimuth_rad * uniform(own, -1, 1);
    place[1] = uniform(own, pitch.low, pitch.high);
    place[2] = uniform(own, config.distance_min_m, config.distance_max_m);
    places.push_back(place);
  }
  return places;
}

/// Whether a camera may stand there: above the ground, outside fruits, with nothing on its lens.
class Room {
 public:
  explicit Room(const Scene& scene) {
    for (const Instance& instance : scene.instances) {
      if (instance.is_specimen) {
        const Mesh& mesh = scene.models[static_cast<std::size_t>(instance.model)].mesh;
        double radius_m = 0;
        for (const Vector3d& p : mesh.vertices_m) radius_m = std::max(radius_m, p.norm());
        balls_.push_back({instance.world_from_object.translation_m, radius_m});
      } else if (instance.category == "leaf") {
        balls_.push_back({instance.world_from_object * Vector3d(0.06, 0, 0), 0.035});
      }
    }
  }
  bool is_free(const Vector3d& eye_m) const {
    if (eye_m.z() < 0.15) return false;
    return std::none_of(balls_.begin(), balls_.end(), [&](const Ball& ball) {
      return (ball.centre_m - eye_m).norm() < ball.radius_m + kFromLens_m;
    });
  }

 private:
  struct Ball {
    Vector3d centre_m;
    double radius_m;
  };
  std::vector<Ball> balls_;
};

/// The camera, with the target a little beside the middle of its image.
Pose camera_pose(const RigEye& eye, const Vector3d& target_m, const Place& place, Rng rng) {
  const Vector3d from = eye_m(target_m, place);
  const double half = 0.5 * std::min(eye.camera.width_px / eye.camera.fx_px,
                                     eye.camera.height_px / eye.camera.fy_px);
  const double off_m = 0.12 * half * place[2];
  const Vector3d aim =
      target_m + off_m * Vector3d(normal(rng), 0, normal(rng)).cwiseMax(-1.5).cwiseMin(1.5);
  const Pose rolled{
      Eigen::Quaterniond(Eigen::AngleAxisd(truncated_normal(rng, 0, 0.05, 2.5), Vector3d::UnitZ())),
      Vector3d::Zero()};
  return rolled * look_at(from, aim);
}

std::vector<std::size_t> targets_of(const Scene& scene, const ApplesSceneConfig& config,
                                    const std::vector<std::size_t>& apples, Rng rng) {
  const auto& v = config.orchard.views;
  std::vector<std::size_t> targets;
  for (const std::size_t apple : apples) {
    const Vector3d& at = scene.instances[apple].world_from_object.translation_m;
    if (at.z() >= v.fruit_low_m && at.z() <= v.fruit_high_m && at.y() < 0.1)
      targets.push_back(apple);
  }
  if (targets.empty()) targets = apples;
  for (std::size_t i = targets.size(); i > 1; --i)
    std::swap(targets[i - 1], targets[uniform_index(rng, i)]);
  return targets;
}

std::string numbered(const char* what, int view) {
  char text[40];
  std::snprintf(text, sizeof text, "%s %06d", what, view);
  return text;
}

/// One view of a target: where its camera stands and what it shows.
struct TargetView {
  std::size_t target = 0;
  Pose eye_from_world;
  double visible = std::numeric_limits<double>::quiet_NaN();
  std::vector<MovedInstance> moved;  ///< leaves to turn for it
};

constexpr int kTargets = 5;  // fruits that are tried for a view

/// How far a view is from what is asked for; 0 where nothing is.
double off(const ApplesSceneConfig& config, const TargetView& view) {
  if (config.occlusion < 0) return 0;
  return std::isnan(view.visible) ? 1 : std::abs(view.visible - (1 - config.occlusion));
}

/// Where a share of the target is counted: the part of the rig's image about it.
TrueView counting_view(const ApplesSceneConfig& config, const Pose& eye_from_world,
                       const VisibleShare& visible) {
  return view_about(config.eye.camera, eye_from_world, visible.centre_in_world_m(),
                    visible.radius_m(), kSide_px);
}

double reach_m(const ApplesSceneConfig& config) { return config.distance_max_m + 0.1; }

[[noreturn]] void refuse_room(const ApplesSceneConfig& config, int view, const Instance& fruit) {
  throw std::invalid_argument("apples: view " + std::to_string(view) +
                              ": no room for the camera within distance_min_m " +
                              std::to_string(config.distance_min_m) + " .. distance_max_m " +
                              std::to_string(config.distance_max_m) + " of " + fruit.name);
}

/// The first place that is free, or the one at which the occlusion asked for is met; if none is,
/// leaves are turned.
TargetView make_view(const Scene& scene, const ApplesSceneConfig& config, std::size_t target,
                     const TurnableLeaves& leaves, const Room& room, int number, const Rng& rng) {
  const Vector3d centre = scene.instances[target].world_from_object.translation_m;
  std::vector<Place> starts = draw_places(config, number, rng.fork("places"));
  std::erase_if(starts, [&](const Place& p) { return !room.is_free(eye_m(centre, p)); });
  if (starts.empty()) refuse_room(config, number, scene.instances[target]);
  const auto pose_at = [&](const Place& place) {
    return camera_pose(config.eye, centre, place, rng.fork("aim"));
  };
  TargetView view{target, pose_at(starts.front())};
  if (config.occlusion < 0) return view;
  const double wanted = 1 - config.occlusion;
  const VisibleShare visible(scene, target, reach_m(config));
  const ShareFound found =
      find_share(starts,
                 [&](const Place& place) {
                   if (!room.is_free(eye_m(centre, place)))
                     return std::numeric_limits<double>::quiet_NaN();
                   return visible.seen(counting_view(config, pose_at(place), visible));
                 },
                 {.wanted = wanted});
  if (found.at.size() > 0) view.eye_from_world = pose_at(found.at);
  view.visible = found.share;
  if (found.met || !config.turns_leaves) return view;
  const MovedLeaves turning =
      turn_leaves(scene, leaves, target, counting_view(config, view.eye_from_world, visible),
                  reach_m(config), wanted);
  if (turning.found.at.size() > 0) view.visible = turning.found.share;
  view.moved = turning.moved;
  return view;
}

/// The view of the next target that meets what is asked for, or of the one that comes nearest; the
/// leaves that are turned for it. @param next  into `targets`; goes on
TargetView take_view(Scene& scene, const ApplesSceneConfig& config,
                     const std::vector<std::size_t>& targets, std::size_t& next,
                     TurnableLeaves& leaves, const Room& room, int number, const Rng& rng) {
  TargetView best;
  for (int k = 0; k < kTargets; ++k) {
    const std::size_t target = targets[next++ % targets.size()];
    TargetView view = make_view(scene, config, target, leaves, room, number,
                                rng.fork(static_cast<std::uint64_t>(k)));
    if (k == 0 || off(config, view) < off(config, best)) best = std::move(view);
    if (off(config, best) <= kWithin) break;
  }
  for (const MovedInstance& one : best.moved) {
    scene.instances[one.place].world_from_object = one.world_from_object;
    leaves.turned.insert(one.place);
  }
  return best;
}

/// A camera before the whole tree: views of one side go from left to right.
Pose tree_pose(const ApplesSceneConfig& config, int view, Rng rng) {
  const auto& v = config.orchard.views;
  const bool is_front = view % 2 == 0;
  const int place = view / 2, count = is_front ? (config.views + 1) / 2 : config.views / 2;
  const double across = count > 1 ? 2.0 * place / (count - 1) - 1 : 0;
  const double azimuth = (is_front ? -0.5 : 0.5) * std::numbers::pi + v.tree_azimuth_rad * across +
                         truncated_normal(rng, 0, 0.04, 2);
  const double distance_m = v.tree_m * (1 + truncated_normal(rng, 0, 0.03, 2));
  const double rise_m = (place % 2 == 0 ? -1 : 1) * v.tree_rise_m;
  const Vector3d aim(0.05 * truncated_normal(rng, 0, 1, 2), 0, v.tree_height_m);
  const Vector3d from(distance_m * std::cos(azimuth), distance_m * std::sin(azimuth),
                      std::max(0.2, v.tree_height_m + rise_m));
  return look_at(from, aim);
}

/// What is said of a view: its target, and of an occlusion asked for whether it is met.
/// @throws std::invalid_argument if it is not and that is to be refused.
std::vector<TrueTrait> notes_of(const Scene& scene, const ApplesSceneConfig& config,
                                const TargetView& view, int number) {
  const Instance& fruit = scene.instances[view.target];
  std::vector<TrueTrait> notes = {{numbered("target", number), "1", static_cast<double>(fruit.id)}};
  if (config.occlusion < 0) return notes;
  const bool met = off(config, view) <= kWithin;
  if (!met && config.unmet == "refuse") {
    throw std::invalid_argument("apples: occlusion = " + std::to_string(config.occlusion) + " of " +
                                fruit.name + " is not met in view " + std::to_string(number) +
                                ": the nearest hides " + std::to_string(1 - view.visible));
  }
  notes.push_back({numbered("visible", number), "1", view.visible});
  notes.push_back({numbered("met", number), "1", met ? 1.0 : 0.0});
  return notes;
}

/// Sharp at `focus`, at its own time.
View still_view(const ApplesSceneConfig& config, int number, const Pose& eye_from_world,
                const Vector3d& focus_in_world_m) {
  View view;
  view.time_s = 2.0 * number;
  view.rig_from_world = inverse(config.eye.eye_from_rig) * eye_from_world;
  view.rig_from_world_end = view.rig_from_world;
  view.focus_in_world_m = focus_in_world_m;
  return view;
}

}  // namespace

void add_tree_views(Scene& scene, const ApplesSceneConfig& config, const Rng& rng) {
  const auto& v = config.orchard.views;
  for (int i = 0; i < config.views; ++i) {
    const Pose eye_from_world =
        tree_pose(config, i, rng.fork("tree").fork(static_cast<std::uint64_t>(i)));
    const Vector3d eye = inverse(eye_from_world).translation_m;
    constexpr double kCrown_m = 0.5;  // of fruits before the trunk
    const Vector3d towards = (eye.cwiseProduct(Vector3d(1, 1, 0))).normalized();
    scene.views.push_back(still_view(config, i, eye_from_world,
                                     Vector3d(0, 0, v.tree_height_m) + kCrown_m * towards));
  }
}

void add_apple_views(Scene& scene, const ApplesSceneConfig& config,
                     const std::vector<std::size_t>& apples, TurnableLeaves& leaves,
                     std::size_t tree, const Rng& rng) {
  if (apples.empty())
    throw std::invalid_argument("apples: fruits = 0 leaves no target for the views");
  const std::vector<std::size_t> targets = targets_of(scene, config, apples, rng.fork("targets"));
  const Room room(scene);
  std::vector<TargetView> made;
  std::size_t next = 0;
  for (int i = 0; i < config.views; ++i) {
    made.push_back(take_view(scene, config, targets, next, leaves, room, i,
                             rng.fork("view").fork(static_cast<std::uint64_t>(i))));
  }
  std::vector<TrueTrait> notes;
  for (int i = 0; i < config.views; ++i) {
    TargetView& view = made[static_cast<std::size_t>(i)];
    // Leaves that a later view turned may stand in an earlier one.
    if (!leaves.turned.empty()) {
      const VisibleShare visible(scene, view.target, reach_m(config));
      view.visible = visible.seen(counting_view(config, view.eye_from_world, visible));
    }
    for (TrueTrait& note : notes_of(scene, config, view, i)) notes.push_back(std::move(note));
    scene.views.push_back(still_view(config, i, view.eye_from_world,
                                     scene.instances[view.target].world_from_object.translation_m));
  }
  if (config.occlusion >= 0)
    notes.push_back({"leaves_turned", "1", static_cast<double>(leaves.turned.size())});
  auto& traits = scene.instances[tree].traits;
  traits.insert(traits.end(), notes.begin(), notes.end());
}

}  // namespace cousin
