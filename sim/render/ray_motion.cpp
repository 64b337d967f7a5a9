#include "sim/render/ray_motion.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace cousin {
namespace {

constexpr std::size_t kMostSteps = 129;  // RTC_MAX_TIME_STEP_COUNT
constexpr double kStep_rad = std::numbers::pi / 180;

bool same(const Pose& a, const Pose& b) {
  return a.translation_m == b.translation_m && a.rotation.coeffs() == b.rotation.coeffs();
}

/// Whether the instance has one pose all through the span.
bool stands_still(const Instance& instance, const TimeSpan& span_s) {
  if (instance.motion.empty() || !(span_s.end_s > span_s.begin_s)) return true;
  const Pose first = world_from_object(instance, span_s.begin_s);
  if (!same(first, world_from_object(instance, span_s.end_s))) return false;
  return std::all_of(instance.motion.begin(), instance.motion.end(), [&](const TimedPose& p) {
    return p.time_s <= span_s.begin_s || p.time_s >= span_s.end_s ||
           same(first, p.world_from_object);
  });
}

/// Largest shift of a point of the object between the steps, as a share of its size and path.
double step_error(const Instance& instance, const TimeSpan& span_s, const std::vector<Pose>& steps,
                  double reach_m) {
  double error_m = 0, path_m = 0, turn_rad = 0;
  const std::size_t probes = 4 * (steps.size() - 1);
  for (std::size_t i = 0; i + 1 < steps.size(); ++i) {
    path_m += (steps[i + 1].translation_m - steps[i].translation_m).norm();
    turn_rad = std::max(turn_rad, angle_rad(steps[i].rotation.conjugate() * steps[i + 1].rotation));
  }
  if (turn_rad > kStep_rad) return std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i <= probes; ++i) {
    const double fraction = static_cast<double>(i) / static_cast<double>(probes);
    const Pose exact =
        world_from_object(instance, span_s.begin_s + fraction * (span_s.end_s - span_s.begin_s));
    const Pose between = pose_between(steps, fraction);
    error_m =
        std::max(error_m, (exact.translation_m - between.translation_m).norm() +
                              reach_m * angle_rad(exact.rotation.conjugate() * between.rotation));
  }
  return error_m / std::max(reach_m + path_m, 1e-300);
}

}  // namespace

std::vector<Pose> motion_steps(const Instance& instance, const TimeSpan& span_s, double reach_m) {
  if (stands_still(instance, span_s)) return {world_from_object(instance, span_s.begin_s)};
  std::vector<Pose> steps;
  for (std::size_t count = 2; count <= kMostSteps; count = 2 * count - 1) {
    steps.assign(count, Pose{});
    for (std::size_t i = 0; i < count; ++i) {
      const double fraction = static_cast<double>(i) / static_cast<double>(count - 1);
      steps[i] =
          world_from_object(instance, span_s.begin_s + fraction * (span_s.end_s - span_s.begin_s));
    }
    constexpr double kTolerance = 1e-6;
    if (step_error(instance, span_s, steps, reach_m) <= kTolerance) break;
  }
  return steps;
}

Pose pose_between(const std::vector<Pose>& steps, double fraction) {
  if (steps.size() == 1) return steps[0];
  const double position = std::clamp(fraction, 0.0, 1.0) * static_cast<double>(steps.size() - 1);
  const std::size_t before = std::min(static_cast<std::size_t>(position), steps.size() - 2);
  const double t = position - static_cast<double>(before);
  const Pose &a = steps[before], &b = steps[before + 1];
  const double sign = a.rotation.dot(b.rotation) < 0 ? -1 : 1;
  Pose pose;
  pose.rotation.coeffs() = (1 - t) * a.rotation.coeffs() + t * sign * b.rotation.coeffs();
  pose.rotation.normalize();
  pose.translation_m = (1 - t) * a.translation_m + t * b.translation_m;
  return pose;
}

}  // namespace cousin
