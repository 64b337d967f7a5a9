#include "scenes/strawberries/target_views.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>

#include "scenes/strawberries/bed_outline.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

constexpr double kWithin = 0.03;  // of the share asked for: met
constexpr int kStarts = 24;       // places that are drawn for a view
constexpr int kTargets = 5;       // fruits that are tried for a view
constexpr int kSide_px = 96;      // across the target where its share is counted

/// A camera about a target: azimuth, height above it, level distance.
using Place = Eigen::VectorXd;

Vector3d eye_m(const Vector3d& target_m, const Place& place) {
  return target_m +
         Vector3d(place[2] * std::cos(place[0]), place[2] * std::sin(place[0]), place[1]);
}

std::vector<Place> draw_places(const StrawberriesSceneConfig& config, const Rng& rng) {
  std::vector<Place> places;
  for (int k = 0; k < kStarts; ++k) {
    Rng own = rng.fork(static_cast<std::uint64_t>(k));
    Place place(3);
    place[0] = config.azimuth_spread_rad * uniform(own, -1, 1);
    place[1] = config.height_m * uniform(own, -1, 1);
    place[2] = uniform(own, config.distance_min_m, config.distance_max_m);
    places.push_back(place);
  }
  return places;
}

/// Whether a camera may stand there: off the bed, fruits and leaves.
bool has_room(const Scene& scene, const SwingingLeaves& leaves, const Vector3d& eye) {
  constexpr double kFromLens_m = 0.02, kBlade_m = 0.05;
  if (depth_m(leaves.room.bed, eye) > -kFromLens_m) return false;
  for (const HangingFruit& fruit : leaves.room.fruits) {
    if (fruit.depth_m(eye, 2 * kFromLens_m) > -kFromLens_m) return false;
  }
  return std::none_of(leaves.all.begin(), leaves.all.end(), [&](const LoneLeaf& leaf) {
    const Vector3d at_m = scene.instances[leaf.place].world_from_object * leaf.blade_m;
    return (at_m - eye).norm() < kBlade_m + kFromLens_m;
  });
}

/// The camera, with the target a little beside the middle of its image.
Pose camera_pose(const RigEye& eye, const Vector3d& target_m, const Place& place, Rng rng) {
  const double half = 0.5 * std::min(eye.camera.width_px / eye.camera.fx_px,
                                     eye.camera.height_px / eye.camera.fy_px);
  const double off_m = 0.12 * half * place[2];
  const Vector3d aside(0, normal(rng), normal(rng));
  const double roll = truncated_normal(rng, 0, 0.03, 2.5);
  const Pose rolled{Eigen::Quaterniond(Eigen::AngleAxisd(roll, Vector3d::UnitZ())),
                    Vector3d::Zero()};
  return rolled *
         look_at(eye_m(target_m, place), target_m + off_m * aside.cwiseMax(-1.5).cwiseMin(1.5));
}

/// One view of a target: where its camera stands and what it shows.
struct TargetView {
  std::size_t target = 0;
  Pose eye_from_world;
  double visible = std::numeric_limits<double>::quiet_NaN();
  std::vector<MovedInstance> moved;  ///< leaves to swing for it
};

/// How far a view is from what is asked for.
double off(const StrawberriesSceneConfig& config, const TargetView& view) {
  return std::isnan(view.visible) ? 1 : std::abs(view.visible - (1 - config.occlusion));
}

double reach_m(const StrawberriesSceneConfig& config) { return config.distance_max_m + 0.1; }

TrueView counting_view(const StrawberriesSceneConfig& config, const Pose& eye_from_world,
                       const VisibleShare& visible) {
  return view_about(config.eye.camera, eye_from_world, visible.centre_in_world_m(),
                    visible.radius_m(), kSide_px);
}

/// The first place at which the occlusion asked for is met; if none is, leaves are swung.
TargetView make_view(const Scene& scene, const StrawberriesSceneConfig& config, std::size_t target,
                     const SwingingLeaves& leaves, int number, const Rng& rng) {
  const Vector3d centre_m = scene.instances[target].world_from_object.translation_m;
  std::vector<Place> starts = draw_places(config, rng.fork("places"));
  std::erase_if(starts,
                [&](const Place& p) { return !has_room(scene, leaves, eye_m(centre_m, p)); });
  if (starts.empty()) {
    throw std::invalid_argument("strawberries: view " + std::to_string(number) +
                                ": no room for the camera within distance_min_m " +
                                std::to_string(config.distance_min_m) + " .. distance_max_m " +
                                std::to_string(config.distance_max_m) + " of " +
                                scene.instances[target].name);
  }
  const auto pose_at = [&](const Place& place) {
    return camera_pose(config.eye, centre_m, place, rng.fork("aim"));
  };
  const double wanted = 1 - config.occlusion;
  const VisibleShare visible(scene, target, reach_m(config));
  const ShareFound found =
      find_share(starts,
                 [&](const Place& place) {
                   if (!has_room(scene, leaves, eye_m(centre_m, place)))
                     return std::numeric_limits<double>::quiet_NaN();
                   return visible.seen(counting_view(config, pose_at(place), visible));
                 },
                 {.wanted = wanted});
  TargetView view{
      target, pose_at(found.at.size() > 0 ? found.at : starts.front()), found.share, {}};
  if (found.met || !config.swings_leaves) return view;
  MovedLeaves swing =
      swing_leaves(scene, leaves, target, counting_view(config, view.eye_from_world, visible),
                   reach_m(config), wanted);
  if (swing.found.at.size() > 0) view.visible = swing.found.share;
  view.moved = std::move(swing.moved);
  return view;
}

/// The view of the next target that meets what is asked for, or of the one that comes nearest; the
/// leaves are swung for it. @param next  into `targets`; goes on
TargetView take_view(Scene& scene, const StrawberriesSceneConfig& config,
                     const std::vector<std::size_t>& targets, std::size_t& next,
                     SwingingLeaves& leaves, int number, const Rng& rng) {
  TargetView best;
  const int tries = std::min(kTargets, static_cast<int>(targets.size()));
  for (int k = 0; k < tries; ++k) {
    TargetView view = make_view(scene, config, targets[next++ % targets.size()], leaves, number,
                                rng.fork(static_cast<std::uint64_t>(k)));
    if (k == 0 || off(config, view) < off(config, best)) best = std::move(view);
    if (off(config, best) <= kWithin) break;
  }
  for (const MovedInstance& one : best.moved) {
    scene.instances[one.place].world_from_object = one.world_from_object;
    leaves.swung.insert(one.place);
  }
  return best;
}

std::string view_key(const char* what, int view) {
  char text[40];
  std::snprintf(text, sizeof text, "%s %06d", what, view);
  return text;
}

/// What is said of a view: its target and whether the occlusion asked for is met.
/// @throws std::invalid_argument if it is not and that is to be refused.
std::vector<TrueTrait> notes_of(const Scene& scene, const StrawberriesSceneConfig& config,
                                const TargetView& view, int number) {
  const Instance& fruit = scene.instances[view.target];
  const bool met = off(config, view) <= kWithin;
  if (!met && config.unmet == "refuse") {
    throw std::invalid_argument("strawberries: occlusion = " + std::to_string(config.occlusion) +
                                " of " + fruit.name + " is not met in view " +
                                std::to_string(number) + ": the nearest hides " +
                                std::to_string(1 - view.visible));
  }
  return {{view_key("target", number), "1", static_cast<double>(fruit.id)},
          {view_key("visible", number), "1", view.visible},
          {view_key("met", number), "1", met ? 1.0 : 0.0}};
}

}  // namespace

void add_target_views(Scene& scene, const StrawberriesSceneConfig& config,
                      const std::vector<std::size_t>& fruits, SwingingLeaves& leaves,
                      const Rng& rng) {
  std::vector<std::size_t> targets = fruits;
  Rng order = rng.fork("order");
  for (std::size_t i = targets.size(); i > 1; --i)
    std::swap(targets[i - 1], targets[uniform_index(order, i)]);
  std::vector<TargetView> made;
  std::size_t next = 0;
  for (int i = 0; i < config.views; ++i) {
    made.push_back(take_view(scene, config, targets, next, leaves, i,
                             rng.fork("view").fork(static_cast<std::uint64_t>(i))));
  }
  scene.views.clear();
  auto& traits = scene.instances.front().traits;  // the bed's
  for (int i = 0; i < config.views; ++i) {
    TargetView& view = made[static_cast<std::size_t>(i)];
    // Leaves that a later view swung may stand in an earlier one.
    if (!leaves.swung.empty()) {
      const VisibleShare visible(scene, view.target, reach_m(config));
      view.visible = visible.seen(counting_view(config, view.eye_from_world, visible));
    }
    for (TrueTrait& note : notes_of(scene, config, view, i)) traits.push_back(std::move(note));
    View seen;
    seen.time_s = 2.0 * i;
    seen.rig_from_world = inverse(config.eye.eye_from_rig) * view.eye_from_world;
    seen.rig_from_world_end = seen.rig_from_world;
    seen.focus_in_world_m = scene.instances[view.target].world_from_object.translation_m;
    scene.views.push_back(seen);
  }
  traits.push_back({"leaves_swung", "1", static_cast<double>(leaves.swung.size())});
}

}  // namespace cousin
