#include "sim/geometry/crease_descent.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "sim/geometry/box_search.h"

namespace cousin::geometry {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::size_t kMaxCreases = 12;

/// To first order in the turn w, two points touch the same side where normal . w = offset.
struct Crease {
  Vector3d normal;
  double offset = 0;
  double turn_rad() const { return std::abs(offset) / normal.norm(); }
};

Matrix3d turned(const Matrix3d& axes, const Vector3d& turn_rad) {
  const double angle = turn_rad.norm();
  if (!(angle > 0)) return axes;
  return Eigen::AngleAxisd(angle, turn_rad / angle).toRotationMatrix() * axes;
}

/// Creases between the point that touches a side now and the others, nearest first, within
/// `reach_rad`. The height p . u of a point along an axis u becomes p . u + w . (u x p).
std::vector<Crease> creases_near(const PointSet& points, const Matrix3d& axes, double reach_rad) {
  std::vector<Crease> creases;
  for (int k = 0; k < 3; ++k) {
    const Vector3d u = axes.col(k);
    const PointSet::Extremes ends = points.extremes(u);
    for (const double sign : {1.0, -1.0}) {
      const Vector3d touching = points[sign > 0 ? ends.high : ends.low];
      for (std::size_t i = 0; i < points.size(); ++i) {
        const Vector3d d = points[i] - touching;
        const Crease crease{sign * u.cross(d), -sign * u.dot(d)};
        // Below the touching point by `offset`; a turn of reach_rad lifts it by at most that times
        // the lever.
        if (crease.normal.norm() * reach_rad > crease.offset && crease.normal.norm() > 1e-9)
          creases.push_back(crease);
      }
    }
  }
  std::stable_sort(creases.begin(), creases.end(),
                   [](const Crease& a, const Crease& b) { return a.turn_rad() < b.turn_rad(); });
  if (creases.size() > kMaxCreases) creases.resize(kMaxCreases);
  return creases;
}

class Trial {
 public:
  Trial(const PointSet& points, const Matrix3d& axes, double reach_rad)
      : points_(points), axes_(axes), reach_rad_(reach_rad), volume_(box_volume(points, axes)) {}

  double at(const Vector3d& turn_rad) {
    const Matrix3d trial = turned(axes_, turn_rad);
    const double volume = box_volume(points_, trial);
    if (volume < volume_) {
      volume_ = volume;
      best_ = turn_rad;
    }
    return volume;
  }

  /// Where three creases meet.
  void corner(const Crease& a, const Crease& b, const Crease& c) {
    Matrix3d normals;
    normals << a.normal.transpose(), b.normal.transpose(), c.normal.transpose();
    const Vector3d turn = normals.inverse() * Vector3d(a.offset, b.offset, c.offset);
    if (turn.allFinite() && turn.norm() <= reach_rad_) at(turn);
  }

  /// Along the line where two creases meet: the point nearest to no turn, and the bottom of a
  /// parabola through it.
  void line(const Crease& a, const Crease& b) {
    const Vector3d direction = a.normal.cross(b.normal);
    const double length = direction.norm();
    if (!(length > 1e-9 * a.normal.norm() * b.normal.norm())) return;
    Matrix3d rows;
    rows << a.normal.transpose(), b.normal.transpose(), direction.transpose();
    const Vector3d foot = rows.inverse() * Vector3d(a.offset, b.offset, 0);
    if (!foot.allFinite() || foot.norm() > reach_rad_) return;
    const Vector3d step = 0.5 * reach_rad_ / length * direction;
    const double before = at(foot - step), here = at(foot), after = at(foot + step);
    const double bend = before - 2 * here + after;
    if (bend > 0) at(foot + std::clamp(0.5 * (before - after) / bend, -1.0, 1.0) * step);
  }

  const Vector3d& best() const { return best_; }
  double volume() const { return volume_; }

 private:
  const PointSet& points_;
  const Matrix3d& axes_;
  double reach_rad_;
  double volume_;
  Vector3d best_ = Vector3d::Zero();
};

}  // namespace

Matrix3d descend_creases(const PointSet& points, const Matrix3d& start) {
  constexpr double kFirstReach = 1e-3, kLastReach = 1e-11;
  constexpr int kMaxRounds = 60;
  Matrix3d axes = start;
  double reach = kFirstReach;
  for (int round = 0; round < kMaxRounds && reach > kLastReach; ++round) {
    const std::vector<Crease> creases = creases_near(points, axes, reach);
    Trial trial(points, axes, reach);
    const double before = trial.volume();
    for (std::size_t i = 0; i < creases.size(); ++i) {
      for (std::size_t j = i + 1; j < creases.size(); ++j) {
        trial.line(creases[i], creases[j]);
        for (std::size_t k = j + 1; k < creases.size(); ++k)
          trial.corner(creases[i], creases[j], creases[k]);
      }
    }
    axes = Eigen::Quaterniond(turned(axes, trial.best())).normalized().toRotationMatrix();
    if (!(trial.volume() < before * (1 - 1e-13))) reach *= 0.2;
  }
  return axes;
}

}  // namespace cousin::geometry
