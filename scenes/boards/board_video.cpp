#include "scenes/boards/board_video.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

namespace cousin {

PosePath::PosePath(std::vector<Pose> poses, double step_s)
    : poses_(std::move(poses)), step_s_(step_s) {
  if (poses_.size() < 4)
    throw std::invalid_argument("path of " + std::to_string(poses_.size()) + " poses; it takes 4");
  for (std::size_t i = 1; i < poses_.size(); ++i) {
    // q and -q are one rotation: the mean is taken on one side.
    if (poses_[i].rotation.dot(poses_[i - 1].rotation) < 0)
      poses_[i].rotation.coeffs() = -poses_[i].rotation.coeffs();
  }
}

int PosePath::pose_count(double length_s, double step_s) {
  return std::max(1, static_cast<int>(std::ceil(length_s / step_s))) + 3;
}

Pose PosePath::at(double time_s) const {
  const double last = static_cast<double>(poses_.size() - 3);
  const double u = std::clamp(time_s / step_s_, 0.0, last);
  const auto first = std::min(static_cast<std::size_t>(u), poses_.size() - 4);
  const double t = u - static_cast<double>(first), s = 1 - t;
  const std::array<double, 4> weights = {s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6,
                                         (3 * s * s * s - 6 * s * s + 4) / 6, t * t * t / 6};
  Pose pose;
  pose.rotation.coeffs().setZero();
  for (std::size_t k = 0; k < weights.size(); ++k) {
    pose.rotation.coeffs() += weights[k] * poses_[first + k].rotation.coeffs();
    pose.translation_m += weights[k] * poses_[first + k].translation_m;
  }
  pose.rotation.normalize();
  return pose;
}

}  // namespace cousin
