#include "sim/geometry/point_set.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <limits>
#include <stdexcept>
#include <string>

namespace cousin::geometry {
namespace {

constexpr std::size_t kLanes = 8;

/// Direction and length of the longest of `vectors` after `project`, by a function of each point.
template <class Residual>
std::pair<Eigen::Vector3d, double> longest(std::span<const Eigen::Vector3d> points,
                                           const Residual& residual) {
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3d r = residual(p);
    if (r.squaredNorm() > best.squaredNorm()) best = r;
  }
  return {best, best.norm()};
}

}  // namespace

void PointSet::reserve(std::size_t count) {
  for (auto* values : {&x_, &y_, &z_}) values->reserve(count + kLanes);
}

void PointSet::add(double x, double y, double z) {
  x_.push_back(x);
  y_.push_back(y);
  z_.push_back(z);
  ++count_;
}

void PointSet::pad() {
  if (count_ == 0) return;
  const std::size_t padded = (count_ + kLanes - 1) / kLanes * kLanes;
  x_.resize(padded, x_[0]);
  y_.resize(padded, y_[0]);
  z_.resize(padded, z_[0]);
}

PointSet::Extent PointSet::extent(const Eigen::Vector3d& direction) const {
  std::array<double, kLanes> low, high;
  low.fill(std::numeric_limits<double>::infinity());
  high.fill(-std::numeric_limits<double>::infinity());
  const double a = direction.x(), b = direction.y(), c = direction.z();
  for (std::size_t i = 0; i < x_.size(); i += kLanes) {
    for (std::size_t k = 0; k < kLanes; ++k) {
      const double h = a * x_[i + k] + b * y_[i + k] + c * z_[i + k];
      low[k] = h < low[k] ? h : low[k];
      high[k] = h > high[k] ? h : high[k];
    }
  }
  return {*std::min_element(low.begin(), low.end()), *std::max_element(high.begin(), high.end())};
}

PointSet::Extremes PointSet::extremes(const Eigen::Vector3d& direction) const {
  const Extent range = extent(direction);
  Extremes found;
  bool have_low = false, have_high = false;
  const double a = direction.x(), b = direction.y(), c = direction.z();
  for (std::size_t i = 0; i < count_ && !(have_low && have_high); ++i) {
    const double h = a * x_[i] + b * y_[i] + c * z_[i];
    if (!have_low && h <= range.low) found.low = i, have_low = true;
    if (!have_high && h >= range.high) found.high = i, have_high = true;
  }
  return found;
}

void check_points(std::span<const Eigen::Vector3d> points_m) {
  if (points_m.empty()) throw std::invalid_argument("no points; at least one is needed");
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    if (!points_m[i].allFinite())
      throw std::invalid_argument("point " + std::to_string(i) + " is not finite");
  }
}

Flat find_flat(std::span<const Eigen::Vector3d> points_m, double tolerance) {
  Eigen::Vector3d low = points_m.front(), high = low;
  for (const Eigen::Vector3d& p : points_m) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  Flat flat;
  flat.origin_m = 0.5 * low + 0.5 * high;  // in halves: the sum of two huge numbers may overflow
  flat.extent_m = (high - low).maxCoeff();
  // Coordinates far from the origin are rounded by up to half an ulp: thinner than that is flat.
  const double rounding = std::numeric_limits<double>::epsilon() *
                          std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff());
  const double limit = tolerance * flat.extent_m + 4 * rounding;
  if (!(flat.extent_m > 0)) return flat;

  // Grow a basis from the point that is farthest from what the basis spans so far.
  const Eigen::Vector3d start = points_m.front();
  const auto [first, length] =
      longest(points_m, [&](const Eigen::Vector3d& p) -> Eigen::Vector3d { return p - start; });
  const Eigen::Vector3d u = first / length;
  const auto [second, breadth] =
      longest(points_m, [&](const Eigen::Vector3d& p) -> Eigen::Vector3d {
        const Eigen::Vector3d d = p - start;
        return d - d.dot(u) * u;
      });
  const bool line = breadth <= limit;
  Eigen::Vector3d v = line ? u.unitOrthogonal() : Eigen::Vector3d(second / breadth);
  v = (v - v.dot(u) * u).normalized();
  const Eigen::Vector3d w = u.cross(v);
  double thickness = 0;
  for (const Eigen::Vector3d& p : points_m)
    thickness = std::max(thickness, std::abs(w.dot(p - start)));
  flat.axes << u, v, w;
  flat.dimension = line ? 1 : (thickness <= limit ? 2 : 3);
  return flat;
}

}  // namespace cousin::geometry
