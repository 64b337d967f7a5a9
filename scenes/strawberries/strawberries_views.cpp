#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "scenes/strawberries/strawberries_scene.h"

namespace cousin {

std::vector<View> strawberry_views(const StrawberriesSceneConfig& config,
                                   const Eigen::Vector3d& middle_m, Rng rng) {
  using Eigen::Vector3d;
  std::vector<View> views;
  for (int i = 0; i < config.views; ++i) {
    Rng own = rng.fork(static_cast<std::uint64_t>(i));
    // Each view in a stratum of its own, from the left to the right.
    const double turn = 2 * (i + uniform(own)) / config.views - 1;
    const double azimuth = config.azimuth_spread_rad * turn;
    const double distance_m = uniform(own, config.distance_min_m, config.distance_max_m);
    // Level by hand, or looking down by 10 to 15 degrees [Strawberries 2.1].
    const bool tilted = uniform(own) < config.tilted_share;
    const double down = uniform(own, config.pitch_min_rad, config.pitch_max_rad);
    const double level = 0.03 * truncated_normal(own, 0, 1, 2);
    const double pitch = tilted ? down : level;
    // Who looks down stands above.
    const double above_m = config.height_m * uniform(own, tilted ? 0.6 : -1, 1);
    const Vector3d aside(0, 0.03 * truncated_normal(own, 0, 1, 2), 0);
    const Vector3d out(std::cos(azimuth), std::sin(azimuth), 0);
    Vector3d eye_m = middle_m + aside + distance_m * out;
    eye_m.z() = middle_m.z() + above_m;
    // At about the fruits' height: who looks down has them above the picture's middle.
    const Vector3d along = -std::cos(pitch) * out - std::sin(pitch) * Vector3d::UnitZ();
    View view;
    view.time_s = 2.0 * i;
    const double roll = truncated_normal(own, 0, 0.03, 2.5);
    const Pose rolled{Eigen::Quaterniond(Eigen::AngleAxisd(roll, Vector3d::UnitZ())),
                      Vector3d::Zero()};
    view.rig_from_world = rolled * look_at(eye_m, eye_m + along);
    view.rig_from_world_end = view.rig_from_world;
    view.focus_in_world_m = middle_m;
    views.push_back(view);
  }
  return views;
}

}  // namespace cousin
