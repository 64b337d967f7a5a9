#include "sim/physics/rigid_sway.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace cousin {
namespace {

constexpr double kStep_s = 0.005, kBefore_s = 0.1, kAfter_s = 0.5;

struct Swing {
  Eigen::Vector2d lean_rad = Eigen::Vector2d::Zero();  ///< towards +x and +y
  Eigen::Vector2d rate_rad_s = Eigen::Vector2d::Zero();
};

Pose leaned(const Pose& at_rest, const Eigen::Vector2d& lean_rad) {
  Pose pose = at_rest;
  const double angle = lean_rad.norm();
  if (angle == 0) return pose;
  const Eigen::Vector3d axis(-lean_rad.y() / angle, lean_rad.x() / angle, 0);
  pose.rotation = (Eigen::AngleAxisd(angle, axis) * at_rest.rotation).normalized();
  return pose;
}

}  // namespace

Fields fields(RigidSwayConfig& c) {
  return {{"frequency_hz", &c.frequency_hz, "of free swings", 0.1, 10},
          {"damping", &c.damping, "share of the critical", 0.001, 1},
          {"lean_rad_s2_m2", &c.lean_rad_s2_m2, "lean over the wind's speed squared", 0, 0.1},
          {"frequency_spread", &c.frequency_spread, "sigma from plant to plant", 0, 0.5}};
}

std::vector<TimedPose> rigid_sway(const RigidSwayConfig& config, const WindField& wind,
                                  const Pose& at_rest, const Eigen::Vector3d& at_m,
                                  const std::vector<double>& times_s, Rng rng) {
  if (!std::is_sorted(times_s.begin(), times_s.end()))
    throw std::invalid_argument("rigid_sway: the times are not sorted");
  const double frequency_hz =
      config.frequency_hz * (1 + config.frequency_spread * truncated_normal(rng, 0, 1, 2));
  if (!(frequency_hz > 0 && kStep_s * frequency_hz <= 0.05)) {
    throw std::invalid_argument("rigid_sway: a frequency of " + std::to_string(frequency_hz) +
                                " Hz is not in (0, 10]");
  }
  const double w = 2 * std::numbers::pi * frequency_hz;
  const Eigen::Vector3d where_m = at_rest * at_m;
  Swing swing;
  const auto step = [&](double time_s) {  // semi-implicit Euler
    const Eigen::Vector3d u = wind_m_s(wind, where_m, time_s);
    const Eigen::Vector2d rest_rad = config.lean_rad_s2_m2 * u.norm() * u.head<2>();
    swing.rate_rad_s +=
        kStep_s * (w * w * (rest_rad - swing.lean_rad) - 2 * config.damping * w * swing.rate_rad_s);
    swing.lean_rad += kStep_s * swing.rate_rad_s;
    // Stalks give way and lie down; they do not turn about.
    constexpr double kMost_rad = 1;
    if (swing.lean_rad.norm() > kMost_rad)
      swing = {kMost_rad * swing.lean_rad.normalized(), {0, 0}};
  };
  std::vector<TimedPose> motion;
  double end_s = -1e300;  // of the last window
  long next = 0;          // step that comes
  for (const double time_s : times_s) {
    const auto first = static_cast<long>(std::floor((time_s - kBefore_s) / kStep_s));
    const auto last = static_cast<long>(std::ceil((time_s + kAfter_s) / kStep_s));
    const auto start = first - static_cast<long>(8 / frequency_hz / kStep_s);
    // After a long pause a swing of its own: what was before it has died away.
    if (motion.empty() || start > next) {
      swing = {};
      next = start;
    }
    for (; next <= last; ++next) {
      step(static_cast<double>(next) * kStep_s);
      const double now_s = static_cast<double>(next + 1) * kStep_s;
      if (next >= first && now_s > end_s)
        motion.push_back({now_s, leaned(at_rest, swing.lean_rad)});
    }
    end_s = motion.back().time_s;
  }
  return motion;
}

Fields scene_wind_fields(WindConfig& config) {
  Fields gusts;
  for (Field& field : fields(config)) {
    if (field.key != "mean_speed_m_s") gusts.push_back(std::move(field));
  }
  constexpr double kStorm_m_s = 30;
  return Fields{{"wind", &config.mean_speed_m_s,
                 "mean speed in m/s, in which plants sway while they are photographed; 0 = still",
                 0, kStorm_m_s}} +
         nested("gusts", std::move(gusts));
}

void sway_specimens(Scene& scene, const WindConfig& wind_config, const RigidSwayConfig& config,
                    double height_share, const Rng& rng) {
  if (!(wind_config.mean_speed_m_s > 0)) return;
  const WindField wind = make_wind(wind_config, rng.fork("wind"));
  std::vector<double> times_s;
  for (const View& view : scene.views) times_s.push_back(view.time_s);
  for (Instance& instance : scene.instances) {
    if (!instance.is_specimen) continue;
    double height_m = 0;
    for (const TrueTrait& trait : instance.traits)
      if (trait.name == "height") height_m = trait.value;
    instance.motion =
        rigid_sway(config, wind, instance.world_from_object, {0, 0, height_share * height_m},
                   times_s, rng.fork("plant").fork(static_cast<std::uint64_t>(instance.id)));
  }
}

}  // namespace cousin
