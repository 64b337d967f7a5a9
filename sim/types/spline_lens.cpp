#include "sim/types/spline_lens.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>

namespace cousin {
namespace {

constexpr int kMostAside = 1024;
constexpr int kMostControlPoints = 16384;
constexpr double kWidestFov_rad = 6.2;
constexpr double kLargestDelta = 100;

/// A cubic reaches a whole interval beyond its end control points' neighbours, a quadratic half of
/// one; `margin` counts both ends.
int margin_intervals(const SplineLens& lens) { return lens.order == 2 ? 1 : 2; }

double knots_per_u(const SplineLens& lens) {
  const double half_width = 2 * std::tan(lens.fov_x_rad / 4);
  return (lens.columns - 1 - margin_intervals(lens)) / (2 * half_width);
}

/// The control points that matter along one axis, their weights, and the weights' derivatives by
/// the position in knots.
struct Basis {
  int first = 0;
  int count = 0;
  std::array<double, 4> weight{};
  std::array<double, 4> slope{};
};

Basis quadratic_basis(double position, int knots) {
  const int middle = std::clamp(static_cast<int>(position + 0.5), 1, knots - 2);
  const double t = position - middle;
  Basis b;
  b.first = middle - 1;
  b.count = 3;
  b.weight = {0.5 * (0.5 - t) * (0.5 - t), 0.75 - t * t, 0.5 * (0.5 + t) * (0.5 + t), 0};
  b.slope = {t - 0.5, -2 * t, t + 0.5, 0};
  return b;
}

Basis cubic_basis(double position, int knots) {
  const int left = std::clamp(static_cast<int>(position), 1, knots - 3);
  const double t = position - left, s = 1 - t;
  Basis b;
  b.first = left - 1;
  b.count = 4;
  b.weight = {s * s * s / 6, (t * t * (3 * t - 6) + 4) / 6, (t * (3 + t * (3 - 3 * t)) + 1) / 6,
              t * t * t / 6};
  b.slope = {-0.5 * s * s, t * (1.5 * t - 2), 0.5 + t * (1 - 1.5 * t), 0.5 * t * t};
  return b;
}

Basis basis(int order, double position, int knots) {
  return order == 2 ? quadratic_basis(position, knots) : cubic_basis(position, knots);
}

/// The surface is known to reach u.
SplinePoint bent_inside(const SplineLens& lens, const Eigen::Vector2d& u) {
  const double scale = knots_per_u(lens);
  const Basis x = basis(lens.order, u.x() * scale + 0.5 * (lens.columns - 1), lens.columns);
  const Basis y = basis(lens.order, u.y() * scale + 0.5 * (lens.rows - 1), lens.rows);
  Eigen::Vector2d delta = Eigen::Vector2d::Zero();
  Eigen::Matrix2d slope = Eigen::Matrix2d::Zero();
  for (int j = 0; j < y.count; ++j) {
    const auto jj = static_cast<std::size_t>(j);
    const std::size_t row =
        static_cast<std::size_t>(y.first + j) * static_cast<std::size_t>(lens.columns) +
        static_cast<std::size_t>(x.first);
    for (int i = 0; i < x.count; ++i) {
      const auto ii = static_cast<std::size_t>(i);
      const Eigen::Map<const Eigen::Vector2d> control(lens.delta_u.data() + 2 * (row + ii));
      delta += x.weight[ii] * y.weight[jj] * control;
      slope.col(0) += x.slope[ii] * y.weight[jj] * control;
      slope.col(1) += x.weight[ii] * y.slope[jj] * control;
    }
  }
  return {u + delta, Eigen::Matrix2d::Identity() + scale * slope};
}

/// Newton's method from `u`, which lies on the surface; the last point and its distance.
struct Found {
  Eigen::Vector2d u;
  double error = 0;
};
Found newton(const SplineLens& lens, const Eigen::Vector2d& target, Eigen::Vector2d u) {
  const Eigen::Vector2d limit = half_extent(lens);
  SplinePoint at = bent_inside(lens, u);
  double error = (at.value - target).norm();
  for (int i = 0; i < 50 && error > 1e-15; ++i) {
    if (!(std::abs(at.d_u.determinant()) > 1e-12)) break;
    const Eigen::Vector2d step = at.d_u.inverse() * (target - at.value);
    bool improved = false;
    for (double scale = 1; scale > 1e-4 && !improved; scale *= 0.5) {
      const Eigen::Vector2d next_u = (u + scale * step).cwiseMax(-limit).cwiseMin(limit);
      const SplinePoint next = bent_inside(lens, next_u);
      const double next_error = (next.value - target).norm();
      if (!(next_error < error)) continue;
      u = next_u;
      at = next;
      error = next_error;
      improved = true;
    }
    if (!improved) break;
  }
  return {u, error};
}

[[noreturn]] void reject(const char* field, double value, const std::string& limit) {
  std::ostringstream text;
  text.precision(17);
  text << "spline lens: " << field << " = " << value << " " << limit;
  throw std::invalid_argument(text.str());
}

}  // namespace

void validate(const SplineLens& lens) {
  if (lens.order != 2 && lens.order != 3) reject("order", lens.order, "is neither 2 nor 3");
  const std::string range =
      "is outside " + std::to_string(lens.order + 1) + ".." + std::to_string(kMostAside);
  const auto count_ok = [&](int n) { return n > lens.order && n <= kMostAside; };
  if (!count_ok(lens.columns)) reject("columns", lens.columns, range);
  if (!count_ok(lens.rows)) reject("rows", lens.rows, range);
  const int count = lens.columns * lens.rows;
  if (count > kMostControlPoints) {
    reject("columns * rows", count, "is above " + std::to_string(kMostControlPoints));
  }
  if (!(lens.fov_x_rad > 0 && lens.fov_x_rad <= kWidestFov_rad)) {
    reject("fov_x_rad", lens.fov_x_rad, "is not in (0, 6.2]");
  }
  if (lens.delta_u.size() != static_cast<std::size_t>(2 * count)) {
    reject("delta_u's length", static_cast<double>(lens.delta_u.size()),
           "is not 2 columns rows = " + std::to_string(2 * count));
  }
  for (const double value : lens.delta_u) {
    if (!(std::abs(value) <= kLargestDelta)) reject("delta_u", value, "is not in [-100, 100]");
  }
}

Eigen::Vector2d half_extent(const SplineLens& lens) {
  const int margin = margin_intervals(lens);
  return Eigen::Vector2d(lens.columns - 1 - margin, lens.rows - 1 - margin) /
         (2 * knots_per_u(lens));
}

std::optional<SplinePoint> bent(const SplineLens& lens, const Eigen::Vector2d& u) {
  if (!(u.cwiseAbs().array() <= half_extent(lens).array()).all()) return std::nullopt;
  return bent_inside(lens, u);
}

std::optional<Eigen::Vector2d> unbent(const SplineLens& lens, const Eigen::Vector2d& target) {
  constexpr double kTolerance = 1e-9;
  if (!target.allFinite()) return std::nullopt;
  const Eigen::Vector2d limit = half_extent(lens);
  Found found = newton(lens, target, target.cwiseMax(-limit).cwiseMin(limit));
  if (found.error < kTolerance) return found.u;
  // A strongly bent surface: start where it lands nearest.
  Eigen::Vector2d nearest = Eigen::Vector2d::Zero();
  double nearest_distance = std::numeric_limits<double>::infinity();
  const double step = 1 / knots_per_u(lens);
  for (int j = 0; j < lens.rows; ++j) {
    for (int i = 0; i < lens.columns; ++i) {
      const Eigen::Vector2d u =
          (step * Eigen::Vector2d(i - 0.5 * (lens.columns - 1), j - 0.5 * (lens.rows - 1)))
              .cwiseMax(-limit)
              .cwiseMin(limit);
      const double distance = (bent_inside(lens, u).value - target).norm();
      if (distance < nearest_distance) {
        nearest_distance = distance;
        nearest = u;
      }
    }
  }
  found = newton(lens, target, nearest);
  if (found.error < kTolerance) return found.u;
  return std::nullopt;
}

std::optional<Eigen::Vector2d> fold_within(const SplineLens& lens, const Eigen::Vector2d& low,
                                           const Eigen::Vector2d& high) {
  constexpr int kAnInterval = 3;
  const Eigen::Vector2d extent = half_extent(lens);
  const int margin = margin_intervals(lens);
  const int nx = kAnInterval * (lens.columns - 1 - margin);
  const int ny = kAnInterval * (lens.rows - 1 - margin);
  for (int j = 0; j <= ny; ++j) {
    for (int i = 0; i <= nx; ++i) {
      const Eigen::Vector2d share(2.0 * i / nx - 1, 2.0 * j / ny - 1);
      const SplinePoint at = bent_inside(lens, extent.cwiseProduct(share));
      if (at.d_u.determinant() > 0) continue;
      if ((at.value.array() >= low.array()).all() && (at.value.array() <= high.array()).all()) {
        return at.value;
      }
    }
  }
  return std::nullopt;
}

std::optional<StereographicPoint> stereographic(const Eigen::Vector3d& point) {
  const double norm = point.norm();
  // |p| + z, without its cancellation behind the camera.
  const double sum =
      point.z() >= 0 ? norm + point.z() : point.head<2>().squaredNorm() / (norm - point.z());
  if (!(sum > 1e-12 * norm)) return std::nullopt;
  StereographicPoint result;
  result.u = 2 / sum * point.head<2>();
  const Eigen::Vector3d d_sum = point / norm + Eigen::Vector3d::UnitZ();
  result.d_point.leftCols<2>() = 2 / sum * Eigen::Matrix2d::Identity();
  result.d_point.col(2).setZero();
  result.d_point -= result.u / sum * d_sum.transpose();
  return result;
}

Eigen::Vector3d direction_of_stereographic(const Eigen::Vector2d& u) {
  const double t2 = 0.25 * u.squaredNorm();  // tan^2(theta / 2)
  return Eigen::Vector3d(u.x(), u.y(), 1 - t2) / (1 + t2);
}

}  // namespace cousin
