#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/seedlings/seedlings_scene.h"

namespace cousin {
namespace {

/// Radical inverse: places i = 0, 1, 2, ... evenly in [0, 1) [van der Corput 1935].
double radical_inverse(int i, int base) {
  double result = 0, share = 1.0 / base;
  for (; i > 0; i /= base, share /= base) result += share * (i % base);
  return result;
}

}  // namespace

std::vector<View> seedling_views(const SeedlingsSceneConfig& config, Rng rng) {
  constexpr double kTwoPi = 2 * std::numbers::pi;
  Rng start = rng.fork("start");
  const double first_azimuth = kTwoPi * uniform(start);
  const double shift_x = uniform(start), shift_y = uniform(start);
  const double half_x = 0.5 * config.setting.tray.columns * config.setting.tray.pitch_m;
  const double half_y = 0.5 * config.setting.tray.rows * config.setting.tray.pitch_m;
  std::vector<View> views;
  for (int i = 0; i < config.views; ++i) {
    Rng own = rng.fork(static_cast<std::uint64_t>(i));
    // Each view in a stratum of its own; within it at random.
    const double turn = (i + uniform(own)) / config.views;
    const auto wrapped = [](double v) { return v - std::floor(v); };
    const double u = wrapped(radical_inverse(i, 2) + shift_x + 0.3 * uniform(own) / config.views);
    const double v = wrapped(radical_inverse(i, 3) + shift_y + 0.3 * uniform(own) / config.views);
    const double azimuth = first_azimuth + kTwoPi * config.coverage * turn;
    const double tilt = uniform(own, config.tilt_min_rad, config.tilt_max_rad);
    const double distance_m = uniform(own, config.distance_min_m, config.distance_max_m);
    const Eigen::Vector3d aim_m(0.85 * config.coverage * half_x * (2 * u - 1),
                                0.85 * config.coverage * half_y * (2 * v - 1), 0.02);
    const Eigen::Vector3d outward(std::cos(azimuth), std::sin(azimuth), 0);
    const Eigen::Vector3d from =
        std::cos(tilt) * outward + std::sin(tilt) * Eigen::Vector3d::UnitZ();
    // The picture's upper edge is away from the photographer, also where she looks straight down.
    const Eigen::Vector3d up = std::cos(tilt) * Eigen::Vector3d::UnitZ() - std::sin(tilt) * outward;
    View view;
    view.time_s = 2.0 * i;
    const double roll = truncated_normal(own, 0, 0.05, 2.5);
    const Pose rolled{Eigen::Quaterniond(Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ())),
                      Eigen::Vector3d::Zero()};
    view.rig_from_world = rolled * look_at(aim_m + distance_m * from, aim_m, up);
    view.rig_from_world_end = view.rig_from_world;
    view.focus_in_world_m = aim_m;
    views.push_back(view);
  }
  return views;
}

}  // namespace cousin
