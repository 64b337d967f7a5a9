// calibration_run.h's agreement of cameras on boards that hide a half turn.

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <numbers>
#include <vector>

#include "benchmarks/tools/calibrate/calibration_run.h"

namespace cousin {
namespace {

double angle_between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return a.angularDistance(b);
}

/// Numbers counted from the other end.
void turn_half(TargetView& view, int count) {
  for (TargetObservation& o : view.points) o.id = count - 1 - o.id;
  std::reverse(view.points.begin(), view.points.end());
}

/// Each frame's pose by one camera alone.
std::map<int, Pose> poses_alone(const CalibrationInput& input, int camera,
                                const CalibrationConfig& config) {
  CalibrationInput alone;
  alone.target_m = input.target_m;
  alone.cameras = {input.cameras[static_cast<std::size_t>(camera)]};
  for (TargetView view : input.views) {
    if (view.camera != camera) continue;
    view.camera = 0;
    alone.views.push_back(std::move(view));
  }
  std::map<int, Pose> poses;
  const CalibrationResult result = calibrate(alone, config);
  for (const CalibrationFrame& frame : result.frames) poses[frame.frame] = frame.rig_from_target;
  return poses;
}

}  // namespace

void agree_on_half_turns(CalibrationInput& input, const CalibrationConfig& config) {
  const Pose half{Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ())),
                  Eigen::Vector3d::Zero()};
  for (std::size_t c = 1; c < input.cameras.size(); ++c) {
    const std::map<int, Pose> first = poses_alone(input, 0, config);
    const std::map<int, Pose> other = poses_alone(input, static_cast<int>(c), config);
    // Where the camera is from the first, by each frame, and were its board turned.
    struct Pair {
      int frame;
      Eigen::Quaterniond as_is, turned;
    };
    std::vector<Pair> pairs;
    for (const auto& [frame, pose] : other) {
      const auto at = first.find(frame);
      if (at == first.end()) continue;
      const Pose back = inverse(at->second);
      pairs.push_back({frame, (pose * back).rotation, (pose * half * back).rotation});
    }
    const auto distance = [&](const Eigen::Quaterniond& q) {
      double sum = 0;
      for (const Pair& p : pairs)
        sum += std::min(angle_between(p.as_is, q), angle_between(p.turned, q));
      return sum;
    };
    const Eigen::Quaterniond* best = nullptr;
    double least = 0;
    // As numbered first: of two equal sums, cameras stand upright to each other.
    for (const bool turned : {false, true}) {
      for (const Pair& p : pairs) {
        const Eigen::Quaterniond& q = turned ? p.turned : p.as_is;
        const double sum = distance(q);
        if (best == nullptr || sum < least - 1e-3) best = &q, least = sum;
      }
    }
    if (best == nullptr) continue;
    for (const Pair& p : pairs) {
      if (angle_between(p.as_is, *best) <= angle_between(p.turned, *best)) continue;
      for (TargetView& view : input.views) {
        if (view.camera == static_cast<int>(c) && view.frame == p.frame &&
            view.status == TargetStatus::half_turn_unknown)
          turn_half(view, static_cast<int>(input.target_m.size()));
      }
    }
  }
}

}  // namespace cousin
