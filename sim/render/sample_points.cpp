#include "sim/render/sample_points.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace cousin {
namespace {

std::uint32_t morton(const Eigen::Vector2f& p) {
  const auto x = static_cast<std::uint32_t>(p.x() * 4096),
             y = static_cast<std::uint32_t>(p.y() * 4096);
  std::uint32_t code = 0;
  for (std::uint32_t bit = 0; bit < 12; ++bit) {
    code |= ((x >> bit) & 1U) << (2 * bit) | ((y >> bit) & 1U) << (2 * bit + 1);
  }
  return code;
}

}  // namespace

std::vector<Eigen::Vector2f> coherent_points(int count) {
  std::vector<Eigen::Vector2f> points;
  for (int i = 0; i < count; ++i) points.push_back(sobol_point(static_cast<std::uint32_t>(i)));
  std::stable_sort(points.begin(), points.end(),
                   [](const auto& a, const auto& b) { return morton(a) < morton(b); });
  return points;
}

Eigen::Vector2f concentric_disk(const Eigen::Vector2f& u) {
  constexpr float kQuarter = std::numbers::pi_v<float> / 4;
  const float x = 2 * u.x() - 1, y = 2 * u.y() - 1;
  if (x == 0 && y == 0) return Eigen::Vector2f::Zero();
  const bool wide = std::abs(x) > std::abs(y);
  const float r = wide ? x : y;
  const float angle = wide ? kQuarter * (y / x) : 2 * kQuarter - kQuarter * (x / y);
  return {r * std::cos(angle), r * std::sin(angle)};
}

Eigen::Matrix3f frame_about(const Eigen::Vector3f& n) {
  const float sign = std::copysign(1.0F, n.z());
  const float a = -1 / (sign + n.z());
  const float b = n.x() * n.y() * a;
  Eigen::Matrix3f frame;
  frame.col(0) = Eigen::Vector3f(1 + sign * n.x() * n.x() * a, sign * b, -sign * n.x());
  frame.col(1) = Eigen::Vector3f(b, sign + n.y() * n.y() * a, -n.y());
  frame.col(2) = n;
  return frame;
}

}  // namespace cousin
