#include "sim/plant/centre_line.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace cousin {
namespace {

void require_positive(const char* what, double value) {
  if (!(value > 0 && std::isfinite(value)))
    throw std::invalid_argument(std::string("axis: ") + what + " = " + std::to_string(value) +
                                " must be positive and finite");
}

Eigen::Vector3d across(const Eigen::Vector3d& tangent, const Eigen::Vector3d& wish) {
  Eigen::Vector3d normal = wish - wish.dot(tangent) * tangent;
  if (normal.norm() > 1e-9) return normal.normalized();
  const Eigen::Vector3d any =
      std::abs(tangent.x()) < 0.9 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  return (any - any.dot(tangent) * tangent).normalized();
}

Eigen::Matrix3d axes_of(const Eigen::Vector3d& tangent, const Eigen::Vector3d& normal) {
  Eigen::Matrix3d axes;
  axes << tangent, normal.cross(tangent), normal;
  return axes;
}

}  // namespace

CentreLine grow_axis(const AxisGrowth& growth) {
  require_positive("length_m", growth.length_m);
  require_positive("radius_base_m", growth.radius_base_m);
  require_positive("radius_tip_m", growth.radius_tip_m);
  if (growth.segments < 1)
    throw std::invalid_argument("axis: segments = " + std::to_string(growth.segments) +
                                " must be at least 1");
  CentreLine line;
  Eigen::Vector3d heading = growth.heading.normalized(), point = growth.start_m;
  const double step_m = growth.length_m / growth.segments;
  for (int i = 0; i <= growth.segments; ++i) {
    const double share = static_cast<double>(i) / growth.segments;
    line.points_m.push_back(point);
    line.radii_m.push_back(growth.radius_base_m +
                           share * (growth.radius_tip_m - growth.radius_base_m));
    point += step_m * heading;
    Eigen::Vector3d turn = Eigen::Vector3d::Zero();
    for (const Tropism& tropism : growth.tropisms) {
      if (share < tropism.begin) continue;
      // From zero at `begin` to twice the mean at the tip.
      const double weight =
          tropism.begin > 0 ? 2 * (share - tropism.begin) / std::pow(1 - tropism.begin, 2) : 1;
      turn += weight * tropism.turn_rad / growth.segments *
              (tropism.towards - tropism.towards.dot(heading) * heading);
    }
    heading = (heading + turn).normalized();
    for (const Curl& curl : growth.curls) {
      // The part of this step that lies beyond `begin`.
      const double begin = std::max(share, curl.begin), end = share + 1.0 / growth.segments;
      if (end <= begin) continue;
      const double angle = curl.angle_rad * (end - begin) / (1 - curl.begin);
      heading = Eigen::AngleAxisd(angle, curl.axis) * heading;
    }
  }
  return line;
}

double length_m(std::span<const Eigen::Vector3d> points_m) {
  double sum = 0;
  for (std::size_t i = 1; i < points_m.size(); ++i) sum += (points_m[i] - points_m[i - 1]).norm();
  return sum;
}

double length_m(const CentreLine& line) { return length_m(std::span(line.points_m)); }

std::vector<Eigen::Matrix3d> frames_along(std::span<const Eigen::Vector3d> points_m,
                                          const Eigen::Vector3d& normal) {
  if (points_m.size() < 2) throw std::invalid_argument("a line needs at least 2 points");
  const auto tangent = [&](std::size_t i) -> Eigen::Vector3d {
    const std::size_t a = i == 0 ? 0 : i - 1, b = std::min(i + 1, points_m.size() - 1);
    return (points_m[b] - points_m[a]).normalized();
  };
  std::vector<Eigen::Matrix3d> frames;
  Eigen::Vector3d up = across(tangent(0), normal);
  frames.push_back(axes_of(tangent(0), up));
  for (std::size_t i = 1; i < points_m.size(); ++i) {
    const Eigen::Vector3d before = tangent(i - 1), now = tangent(i);
    const Eigen::Vector3d step = points_m[i] - points_m[i - 1];
    const Eigen::Vector3d up_mirrored = up - 2 * step.dot(up) / step.squaredNorm() * step;
    const Eigen::Vector3d mirrored = before - 2 * step.dot(before) / step.squaredNorm() * step;
    const Eigen::Vector3d rest = now - mirrored;
    up = rest.squaredNorm() > 1e-24
             ? Eigen::Vector3d(up_mirrored - 2 * rest.dot(up_mirrored) / rest.squaredNorm() * rest)
             : up_mirrored;
    up = across(now, up);
    frames.push_back(axes_of(now, up));
  }
  return frames;
}

LineWalk::LineWalk(CentreLine line, const Eigen::Vector3d& normal)
    : line_(std::move(line)), axes_(frames_along(line_.points_m, normal)) {
  along_m_.push_back(0);
  for (std::size_t i = 1; i < line_.points_m.size(); ++i)
    along_m_.push_back(along_m_.back() + (line_.points_m[i] - line_.points_m[i - 1]).norm());
  length_m_ = along_m_.back();
}

LinePoint LineWalk::at_m(double along_m) const {
  if (along_m <= 0) {
    return {line_.points_m.front() + along_m * axes_.front().col(0), axes_.front(),
            line_.radii_m.front()};
  }
  if (along_m >= length_m_) {
    return {line_.points_m.back() + (along_m - length_m_) * axes_.back().col(0), axes_.back(),
            line_.radii_m.back()};
  }
  const auto next = std::upper_bound(along_m_.begin(), along_m_.end(), along_m);
  const auto b = static_cast<std::size_t>(next - along_m_.begin());
  const std::size_t a = b - 1;
  const double t = (along_m - along_m_[a]) / (along_m_[b] - along_m_[a]);
  LinePoint point;
  point.point_m = (1 - t) * line_.points_m[a] + t * line_.points_m[b];
  point.radius_m = (1 - t) * line_.radii_m[a] + t * line_.radii_m[b];
  const Eigen::Vector3d tangent = ((1 - t) * axes_[a].col(0) + t * axes_[b].col(0)).normalized();
  point.axes = axes_of(tangent, across(tangent, (1 - t) * axes_[a].col(2) + t * axes_[b].col(2)));
  return point;
}

}  // namespace cousin
