#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/seeds/setting.h"
#include "sim/geometry/gradient_noise.h"

namespace cousin {

std::vector<View> camera_path(const SeedsSceneConfig& config, Rng rng) {
  constexpr double kTwoPi = 2 * std::numbers::pi;
  constexpr double kFrameStep_s = 0.5;  // frames are taken from the video at 2 a second [Seeds 2.2]
  const auto rings = static_cast<int>(config.ring_elevations_rad.size());
  const std::uint64_t key = rng.fork("wander")();
  std::vector<View> views;
  for (int i = 0; i < config.views; ++i) {
    // Rings one after the other, as a person walks round; views split evenly, the first rings take
    // the remainder.
    const int ring = static_cast<int>(static_cast<long>(i) * rings / config.views);
    const long first = (static_cast<long>(ring) * config.views + rings - 1) / rings;
    const long next = (static_cast<long>(ring + 1) * config.views + rings - 1) / rings;
    const double turn = static_cast<double>(i - first) / static_cast<double>(next - first);
    Rng view_rng = rng.fork(static_cast<std::uint64_t>(i));

    // Slow wander along the ring, plus a small independent tremor of each view.
    const auto r = static_cast<std::size_t>(ring);
    const Eigen::Vector3d where(3 * turn + 0.37, 10.0 * ring + 0.61, 0.43);
    const auto wander = [&](std::uint64_t channel) {
      return 1.6 * noise3(where, key + channel) + 0.4 * truncated_normal(view_rng, 0, 1, 2);
    };
    const double j = config.view_jitter;
    const double azimuth = kTwoPi * (turn + 0.5 * ring / rings) + j * wander(0);
    const double elevation = std::clamp(config.ring_elevations_rad[r] + j * wander(1), 0.12, 1.45);
    const double distance_m = std::clamp(config.ring_distances_m[r] * (1 + 3 * j * wander(2)),
                                         config.distance_min_m, config.distance_max_m);
    const Eigen::Vector3d direction(std::cos(elevation) * std::cos(azimuth),
                                    std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
    // The aim misses the centre by up to a few per cent of the distance; the plate stays in the
    // image.
    const Eigen::Vector3d aim_m = 0.25 * j * distance_m * Eigen::Vector3d(wander(3), wander(4), 0);
    const double roll = j * wander(5);
    View view;
    view.time_s = kFrameStep_s * i;
    const Pose upright = look_at(distance_m * direction, aim_m);
    const Pose rolled{Eigen::Quaterniond(Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ())),
                      Eigen::Vector3d::Zero()};
    view.rig_from_world = rolled * upright;
    view.rig_from_world_end = view.rig_from_world;
    views.push_back(view);
  }
  return views;
}

}  // namespace cousin
