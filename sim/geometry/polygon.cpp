#include "sim/geometry/polygon.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace cousin::geometry {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Areas below this share of the outline's extent squared are the rounding of coordinates that a
/// file gives with six digits.
constexpr double kFlatShare = 1e-6;
constexpr double kPi = 3.14159265358979323846;

double cross_of(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Twice the signed area; positive where a, b, c run to the left.
double turn(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  return cross_of(b - a, c - a);
}

/// The outline seen along its normal, of unit extent, running to the left.
struct Outline {
  std::vector<Vector2d> points;
  bool has_area = false;
};

Outline outline_of(std::span<const Vector3d> vertices, std::span<const std::uint32_t> corners) {
  const Vector3d first = vertices[corners[0]];
  Vector3d normal = Vector3d::Zero();  // twice the area
  double extent = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector3d a = vertices[corners[i]] - first;
    const Vector3d b = vertices[corners[(i + 1) % corners.size()]] - first;
    normal += a.cross(b);
    extent = std::max(extent, a.cwiseAbs().maxCoeff());
  }
  Outline outline;
  if (!(extent > 0)) return outline;
  outline.has_area = normal.norm() > kFlatShare * extent * extent;
  if (!outline.has_area) return outline;
  normal.normalize();
  const Vector3d x = normal.unitOrthogonal(), y = normal.cross(x);
  outline.points.reserve(corners.size());
  for (const std::uint32_t corner : corners) {
    const Vector3d p = (vertices[corner] - first) / extent;
    outline.points.emplace_back(p.dot(x), p.dot(y));
  }
  return outline;
}

/// Whether the triangles from the first corner cover the outline once: none is turned over, and
/// they go round that corner at most once.
bool is_fan(const std::vector<Vector2d>& p) {
  double angle = 0, turned_over = 0;
  for (std::size_t k = 2; k < p.size(); ++k) {
    const Vector2d a = p[k - 1] - p[0], b = p[k] - p[0];
    turned_over -= std::min(0.0, cross_of(a, b));
    angle += std::max(0.0, std::atan2(cross_of(a, b), a.dot(b)));
  }
  return turned_over <= kFlatShare && angle <= 2 * kPi + kFlatShare;
}

/// Whether two edges pass through each other; those that touch do not.
bool edges_cross(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d) {
  const auto apart = [](double s, double t) {
    return (s > kFlatShare && t < -kFlatShare) || (s < -kFlatShare && t > kFlatShare);
  };
  return apart(turn(a, b, c), turn(a, b, d)) && apart(turn(c, d, a), turn(c, d, b));
}

bool crosses_itself(const std::vector<Vector2d>& p) {
  const std::size_t n = p.size();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 2; j < n; ++j) {
      if (edges_cross(p[i], p[i + 1], p[j], p[(j + 1) % n])) return true;
    }
  }
  return false;
}

/// Cuts ears off an outline that does not cross itself, one after the other.
class EarCutter {
 public:
  explicit EarCutter(const std::vector<Vector2d>& points)
      : p_(points),
        before_(points.size()),
        after_(points.size()),
        is_ear_(points.size()),
        left_(points.size()) {
    for (std::size_t i = 0; i < left_; ++i) {
      before_[i] = (i + left_ - 1) % left_;
      after_[i] = (i + 1) % left_;
    }
    judge_all();
  }

  /// Indices into the points. Fewer than all triangles if there is no ear before the last three.
  std::vector<std::array<std::size_t, 3>> cut() {
    while (left_ > 3) {
      if (cut_next([this](std::size_t i) { return is_ear_[i]; })) continue;
      judge_all();  // rounding may have hidden one
      if (cut_next([this](std::size_t i) { return is_ear_[i]; })) continue;
      // A spike has no area: it goes where nothing else can.
      if (!cut_next([this](std::size_t i) { return std::abs(turn_at(i)) <= kFlatShare; })) break;
    }
    if (left_ == 3) triangles_.push_back({before_[at_], at_, after_[at_]});
    return std::move(triangles_);
  }

 private:
  double turn_at(std::size_t i) const { return turn(p_[before_[i]], p_[i], p_[after_[i]]); }

  /// A corner that turns left and whose triangle holds no other corner. Corners in the place of one
  /// of the triangle's are the other end of a bridge, and not in the way.
  bool is_ear(std::size_t i) const {
    const Vector2d &a = p_[before_[i]], &b = p_[i], &c = p_[after_[i]];
    if (!(turn(a, b, c) > 0)) return false;
    for (std::size_t k = after_[after_[i]]; k != before_[i]; k = after_[k]) {
      const Vector2d& q = p_[k];
      if (q == a || q == b || q == c || turn_at(k) > 0) continue;
      if (turn(a, b, q) >= 0 && turn(b, c, q) >= 0 && turn(c, a, q) >= 0) return false;
    }
    return true;
  }
  void judge_all() {
    for (std::size_t i = 0, k = at_; i < left_; ++i, k = after_[k]) is_ear_[k] = is_ear(k);
  }
  template <class Choice>
  bool cut_next(const Choice& choice) {
    for (std::size_t i = 0; i < left_; ++i, at_ = after_[at_]) {
      if (!choice(at_)) continue;
      const std::size_t a = before_[at_], c = after_[at_];
      triangles_.push_back({a, at_, c});
      after_[a] = c;
      before_[c] = a;
      --left_;
      is_ear_[a] = is_ear(a);
      is_ear_[c] = is_ear(c);
      at_ = c;
      return true;
    }
    return false;
  }

  const std::vector<Vector2d>& p_;
  std::vector<std::size_t> before_, after_;
  std::vector<bool> is_ear_;
  std::size_t left_;
  std::size_t at_ = 0;
  std::vector<std::array<std::size_t, 3>> triangles_;
};

bool has_flat_fan(std::span<const Vector3d> vertices, std::span<const std::uint32_t> corners) {
  const Vector3d first = vertices[corners[0]];
  double extent = 0, largest = 0;
  for (std::size_t k = 1; k < corners.size(); ++k) {
    const Vector3d b = vertices[corners[k]] - first;
    extent = std::max(extent, b.cwiseAbs().maxCoeff());
    largest = std::max(largest, (vertices[corners[k - 1]] - first).cross(b).norm());
  }
  return !(largest > kFlatShare * extent * extent);
}

std::vector<std::array<std::uint32_t, 3>> fan_of(std::span<const std::uint32_t> corners) {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (std::size_t k = 2; k < corners.size(); ++k)
    triangles.push_back({corners[0], corners[k - 1], corners[k]});
  return triangles;
}

}  // namespace

PolygonTriangles triangles_of_polygon(std::span<const Vector3d> vertices,
                                      std::span<const std::uint32_t> corners) {
  if (corners.size() == 3) return {fan_of(corners), ""};
  const std::string crossed =
      "the outline crosses itself; cut it into triangles in the program that made it";
  const Outline outline = outline_of(vertices, corners);
  if (!outline.has_area) {
    if (has_flat_fan(vertices, corners)) return {fan_of(corners), ""};
    return {{}, crossed};
  }
  if (is_fan(outline.points)) return {fan_of(corners), ""};
  if (corners.size() > kMostPolygonCorners) {
    return {{},
            "a concave polygon of " + std::to_string(corners.size()) + " corners; the limit is " +
                std::to_string(kMostPolygonCorners)};
  }
  if (crosses_itself(outline.points)) return {{}, crossed};
  PolygonTriangles result;
  for (const auto& [a, b, c] : EarCutter(outline.points).cut())
    result.triangles.push_back({corners[a], corners[b], corners[c]});
  if (result.triangles.size() + 2 != corners.size()) return {{}, crossed};
  return result;
}

}  // namespace cousin::geometry
