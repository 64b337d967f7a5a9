// The volume as a function of the rotation is continuous, with creases where an edge of the hull
// becomes flush with a side; minima lie on creases [O'Rourke 1985: two adjacent sides are flush
// with edges]. So no derivatives at first: starts all over the rotations, Nelder and Mead's simplex
// at scales from a tenth of a radian down [in the manner of HYBBRID, Chang, Gorissen & Melchior
// 2011], and at last the creases themselves for the digits that are left. Speed comes from exact
// pruning: within an angle of the present axes only few points can touch a side.

#include "sim/geometry/box_search.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "sim/geometry/crease_descent.h"

namespace cousin::geometry {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Rotations evenly over SO(3) [super-Fibonacci spirals, Alexa, CVPR 2022], of which only those
/// stay that are the smallest among the 24 that give the same box: 1200, about 8 degrees apart.
std::vector<Matrix3d> make_rotations() {
  constexpr int kCount = 24 * 1200;
  constexpr double kPhi = std::numbers::sqrt2, kPsi = 1.533751168755204288118041;
  std::vector<Matrix3d> rotations;
  for (int i = 0; i < kCount; ++i) {
    const double s = i + 0.5, t = s / kCount;
    const double alpha = 2 * std::numbers::pi * s / kPhi, beta = 2 * std::numbers::pi * s / kPsi;
    Eigen::Quaterniond q(std::sqrt(1 - t) * std::cos(beta), std::sqrt(t) * std::sin(alpha),
                         std::sqrt(t) * std::cos(alpha), std::sqrt(1 - t) * std::sin(beta));
    const double w = std::abs(q.w());
    const Vector3d v = q.vec().cwiseAbs();
    if (v.maxCoeff() <= (std::numbers::sqrt2 - 1) * w && v.sum() <= w)
      rotations.push_back(q.toRotationMatrix());
  }
  return rotations;
}

/// Directions evenly over the half sphere: a Fibonacci lattice.
std::vector<Vector3d> make_directions(int count) {
  std::vector<Vector3d> directions;
  for (int i = 0; i < count; ++i) {
    const double z = (i + 0.5) / count;
    const double angle = 2 * std::numbers::pi * i / std::numbers::phi;
    const double r = std::sqrt(1 - z * z);
    directions.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
  }
  return directions;
}

/// The points that are extreme in one of many directions: enough to rank rotations.
PointSet thinned(const PointSet& points) {
  static const std::vector<Vector3d> directions = make_directions(400);
  if (points.size() <= 2 * directions.size()) return points;
  std::vector<std::size_t> kept;
  for (const Vector3d& d : directions) {
    const PointSet::Extremes ends = points.extremes(d);
    kept.push_back(ends.low);
    kept.push_back(ends.high);
  }
  std::sort(kept.begin(), kept.end());
  kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
  PointSet out;
  for (const std::size_t i : kept) out.add(points[i].x(), points[i].y(), points[i].z());
  out.pad();
  return out;
}

/// For each axis the points that can be extreme along some direction within `radius` of it.
struct Caps {
  Matrix3d axes = Matrix3d::Identity();
  double radius = 0;
  std::array<PointSet, 3> points;

  double volume(const Matrix3d& rotated) const {
    return points[0].extent(rotated.col(0)).width() * points[1].extent(rotated.col(1)).width() *
           points[2].extent(rotated.col(2)).width();
  }
};

/// The most of h cos t + r sin t over tilts t from 0 to one of the given cosine and sine: the
/// height that a point at height h and distance r from an axis can have along directions around
/// that axis. The least is -most(-h, r).
double most(double h, double r, double cosine, double sine) {
  return h > 0 && r * cosine <= h * sine ? std::hypot(h, r) : h * cosine + r * sine;
}

/// Marks the points that can be the highest or the lowest along some direction within `radius` of
/// `axis`: those whose most is at least every point's least.
void mark_cap(const PointSet& points, const Vector3d& axis, double radius,
              std::vector<char>& marks) {
  const double c = std::cos(radius), s = std::sin(radius);
  struct Reach {
    double height = 0, distance = 0;
  };
  std::vector<Reach> reach(points.size());
  double top = -std::numeric_limits<double>::infinity(), bottom = -top;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3d p = points[i];
    const double h = axis.dot(p);
    const double r = std::sqrt(std::max(0.0, p.squaredNorm() - h * h));
    reach[i] = {h, r};
    top = std::max(top, -most(-h, r, c, s));
    bottom = std::min(bottom, most(h, r, c, s));
  }
  constexpr double kSlack = 1e-14;  // rounding, for points of unit extent
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto [h, r] = reach[i];
    if (most(h, r, c, s) >= top - kSlack || -most(-h, r, c, s) <= bottom + kSlack) marks[i] = 1;
  }
}

PointSet marked(const PointSet& points, const std::vector<char>& marks) {
  PointSet out;
  out.reserve(points.size() / 4);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (marks[i]) out.add(points[i].x(), points[i].y(), points[i].z());
  }
  out.pad();
  return out;
}

PointSet cap(const PointSet& points, const Vector3d& axis, double radius) {
  std::vector<char> marks(points.size());
  mark_cap(points, axis, radius, marks);
  return marked(points, marks);
}

/// All that can touch a box whose axes are within `radius` of these.
PointSet points_near_sides(const PointSet& points, const Matrix3d& axes, double radius) {
  std::vector<char> marks(points.size());
  for (int k = 0; k < 3; ++k) mark_cap(points, axes.col(k), radius, marks);
  return marked(points, marks);
}

Caps make_caps(const PointSet& points, const Matrix3d& axes, double radius) {
  return {axes,
          radius,
          {cap(points, axes.col(0), radius), cap(points, axes.col(1), radius),
           cap(points, axes.col(2), radius)}};
}

Caps narrowed(const Caps& caps, const Matrix3d& axes, double radius) {
  return {axes,
          radius,
          {cap(caps.points[0], axes.col(0), radius), cap(caps.points[1], axes.col(1), radius),
           cap(caps.points[2], axes.col(2), radius)}};
}

Matrix3d rotation(const Vector3d& turn_rad) {
  const double angle = turn_rad.norm();
  if (!(angle > 0)) return Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, turn_rad / angle).toRotationMatrix();
}

double angle_between(const Matrix3d& a, const Matrix3d& b) {
  // By the difference, not by the trace: the arc cosine loses half the digits of small angles.
  return 2 * std::asin(std::min(1.0, (a - b).norm() / (2 * std::numbers::sqrt2)));
}

struct Simplex {
  Vector3d best = Vector3d::Zero();
  double value = 0;
};

/// Nelder and Mead's search over turns of up to `limit_rad`, from a simplex of side `size_rad`
/// about no turn.
template <class Function>
Simplex nelder_mead(const Function& value_of, double start_value, double size_rad, double limit_rad,
                    int evaluations, double side) {
  struct Corner {
    Vector3d x = Vector3d::Zero();
    double f = 0;
  };
  const auto corner = [&](const Vector3d& x) -> Corner {
    --evaluations;
    return {x, x.norm() > limit_rad ? std::numeric_limits<double>::infinity() : value_of(x)};
  };
  std::array<Corner, 4> s;
  s[0].f = start_value;
  for (int k = 0; k < 3; ++k)
    s[static_cast<std::size_t>(k) + 1] = corner(side * size_rad * Vector3d::Unit(k));
  const auto by_value = [](const Corner& a, const Corner& b) { return a.f < b.f; };
  while (evaluations > 0) {
    std::sort(s.begin(), s.end(), by_value);
    const double spread =
        std::max({(s[1].x - s[0].x).norm(), (s[2].x - s[0].x).norm(), (s[3].x - s[0].x).norm()});
    if (spread < 0.02 * size_rad) break;
    const Vector3d middle = (s[0].x + s[1].x + s[2].x) / 3;
    const Corner reflected = corner(2 * middle - s[3].x);
    if (reflected.f < s[0].f) {
      const Corner expanded = corner(3 * middle - 2 * s[3].x);
      s[3] = expanded.f < reflected.f ? expanded : reflected;
    } else if (reflected.f < s[2].f) {
      s[3] = reflected;
    } else {
      const bool outside = reflected.f < s[3].f;
      const Corner contracted = corner(outside ? Vector3d(1.5 * middle - 0.5 * s[3].x)
                                               : Vector3d(0.5 * (middle + s[3].x)));
      if (contracted.f < std::min(reflected.f, s[3].f)) {
        s[3] = contracted;
      } else {
        for (std::size_t k = 1; k < 4; ++k) s[k] = corner(0.5 * (s[0].x + s[k].x));
      }
    }
  }
  const Corner& best = *std::min_element(s.begin(), s.end(), by_value);
  return {best.x, best.f};
}

struct Candidate {
  Matrix3d axes = Matrix3d::Identity();
  double volume = std::numeric_limits<double>::infinity();
};

/// Restarts the simplex search at `first_rad`, then ever smaller, down to `last_rad`.
Candidate refine(const PointSet& points, const Matrix3d& start, double first_rad, double last_rad,
                 int evaluations) {
  constexpr double kReach = 3;  // simplex sizes that a round may move
  Candidate best{start, box_volume(points, start)};
  Caps wide = make_caps(points, start, kReach * first_rad);
  double side = 1;
  int repeats = 0;
  for (double size = first_rad; size >= last_rad;) {
    const bool inside =
        angle_between(wide.axes, best.axes) + kReach * size < wide.radius * (1 + 1e-12);
    Caps caps = inside ? narrowed(wide, best.axes, kReach * size)
                       : make_caps(points, best.axes, kReach * size);
    const Simplex found =
        nelder_mead([&](const Vector3d& turn) { return caps.volume(rotation(turn) * caps.axes); },
                    best.volume, size, kReach * size, evaluations, side);
    wide = std::move(caps);
    side = -side;
    const bool moved = found.value < best.volume;
    if (moved) best = {rotation(found.best) * wide.axes, found.value};
    // A long move says that the minimum may still be far: again at this size, but not without end.
    if (moved && found.best.norm() > size && ++repeats < 8) continue;
    repeats = 0;
    size *= 0.2;
  }
  // Rounding must not leave axes that are not orthonormal.
  best.axes = Eigen::Quaterniond(best.axes).normalized().toRotationMatrix();
  best.volume = box_volume(points, best.axes);
  return best;
}

/// Down to where the creases can be followed, from a start that may be `reach_rad` away.
Candidate finish(const PointSet& points, const Matrix3d& axes, double reach_rad) {
  constexpr double kLastRad = 1e-6;
  const double pool_rad = 4 * reach_rad;
  const PointSet pool = points_near_sides(points, axes, pool_rad);
  Candidate found = refine(pool, axes, reach_rad, kLastRad, 120);
  // Beyond the pool's angle its points no longer tell the volume.
  if (angle_between(found.axes, axes) > pool_rad)
    found = refine(points, axes, reach_rad, kLastRad, 120);
  found.volume = box_volume(points, found.axes);
  return found;
}

/// Dense hulls have many minima within a hair of each other, and a simplex can stall on a crease:
/// starts again from turns by `turn_rad` towards the corners of a cube, and takes the best.
Candidate shaken(const PointSet& points, const Candidate& first, double turn_rad) {
  const double pool_rad = 5 * turn_rad;
  const PointSet pool = points_near_sides(points, first.axes, pool_rad);
  Candidate best = first;
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3d towards(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    Candidate found =
        finish(pool, rotation(turn_rad * towards.normalized()) * first.axes, turn_rad);
    found.volume = box_volume(points, found.axes);
    if (found.volume < best.volume) best = found;
  }
  return best;
}

/// The last digits, from axes within 1e-3 rad of the minimum.
Matrix3d polished(const PointSet& points, const Matrix3d& axes) {
  const Matrix3d found = descend_creases(points_near_sides(points, axes, 0.02), axes);
  return box_volume(points, found) < box_volume(points, axes) ? found : axes;
}

/// Sorts by volume and keeps the best `count` that are not the same box as a better one.
void keep_best(std::vector<Candidate>& candidates, std::size_t count, double apart_rad) {
  std::sort(candidates.begin(), candidates.end(),
            [](const Candidate& a, const Candidate& b) { return a.volume < b.volume; });
  const auto same_box = [&](const Candidate& a, const Candidate& b) {
    // Each axis of one box along some axis of the other, up to sign.
    const Matrix3d dots = (a.axes.transpose() * b.axes).cwiseAbs();
    return dots.rowwise().maxCoeff().minCoeff() > std::cos(apart_rad);
  };
  std::vector<Candidate> kept;
  for (const Candidate& c : candidates) {
    if (kept.size() == count) break;
    if (std::none_of(kept.begin(), kept.end(), [&](const Candidate& k) { return same_box(k, c); }))
      kept.push_back(c);
  }
  candidates = std::move(kept);
}

}  // namespace

double box_volume(const PointSet& points, const Matrix3d& axes) {
  return points.extent(axes.col(0)).width() * points.extent(axes.col(1)).width() *
         points.extent(axes.col(2)).width();
}

Matrix3d search_box_axes(const PointSet& points, const Matrix3d& guess) {
  static const std::vector<Matrix3d> rotations = make_rotations();
  const PointSet few = thinned(points);

  // Starts: all over the rotations, and closely about each axis of the guess (long shapes have
  // narrow valleys there).
  std::vector<Candidate> candidates;
  for (const Matrix3d& r : rotations) candidates.push_back({guess * r, 0});
  for (int k = 0; k < 3; ++k) {
    for (int degree = 0; degree < 90; degree += 3) {
      const Eigen::AngleAxisd turn(degree * std::numbers::pi / 180, Vector3d::Unit(k));
      candidates.push_back({guess * turn.toRotationMatrix(), 0});
    }
  }
  for (Candidate& c : candidates) c.volume = box_volume(few, c.axes);
  keep_best(candidates, 48, 0.1);
  for (Candidate& c : candidates) c = refine(few, c.axes, 0.08, 1e-3, 80);
  keep_best(candidates, 6, 0.02);
  for (Candidate& c : candidates) c = refine(points, c.axes, 0.02, 1e-4, 80);
  keep_best(candidates, 2, 1e-3);
  for (Candidate& c : candidates) c = finish(points, c.axes, 1e-3);
  keep_best(candidates, 1, 0);
  return polished(points, shaken(points, candidates.front(), 0.02).axes);
}

Matrix3d refine_box_axes(const PointSet& points, const Matrix3d& axes) {
  return polished(points, finish(points, axes, 0.05).axes);
}

}  // namespace cousin::geometry
