#include "sim/geometry/rectangle.h"

#include <algorithm>
#include <limits>

namespace cousin::geometry {
namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Counter-clockwise hull without collinear points [Andrew 1979].
std::vector<Eigen::Vector2d> convex_outline(std::vector<Eigen::Vector2d>& points) {
  const auto before = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  };
  std::sort(points.begin(), points.end(), before);
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  std::vector<Eigen::Vector2d> hull;
  const auto add_chain = [&](auto begin, auto end) {
    const std::size_t floor = hull.size() + 1;
    for (auto p = begin; p != end; ++p) {
      while (hull.size() > floor &&
             cross(hull.back() - hull[hull.size() - 2], *p - hull.back()) <= 0)
        hull.pop_back();
      hull.push_back(*p);
    }
    hull.pop_back();  // the first of the other chain
  };
  add_chain(points.begin(), points.end());
  add_chain(points.rbegin(), points.rend());
  return hull;
}

}  // namespace

Eigen::Vector2d smallest_rectangle_side(std::vector<Eigen::Vector2d> points) {
  const std::vector<Eigen::Vector2d> hull = convex_outline(points);
  const std::size_t n = hull.size();
  if (n < 2) return Eigen::Vector2d::UnitX();
  if (n == 2) return (hull[1] - hull[0]).normalized();

  // Rotating calipers [Toussaint 1983]: as the edge turns, the extreme corners only move forward.
  Eigen::Vector2d best_side = Eigen::Vector2d::UnitX();
  double best_area = std::numeric_limits<double>::infinity();
  std::size_t right = 1, top = 1, left = 1;
  const auto advance = [&](std::size_t& at, const Eigen::Vector2d& direction) {
    for (std::size_t k = 0; k < n && direction.dot(hull[(at + 1) % n]) > direction.dot(hull[at]);
         ++k)
      at = (at + 1) % n;
  };
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector2d side = (hull[(i + 1) % n] - hull[i]).normalized();
    const Eigen::Vector2d up(-side.y(), side.x());
    if (i == 0) {
      // From the first edge's end the corners lie in this order along the outline.
      right = 1;
      advance(right, side);
      top = right;
      advance(top, up);
      left = top;
    }
    advance(right, side);
    advance(top, up);
    advance(left, -side);
    const double area = side.dot(hull[right] - hull[left]) * up.dot(hull[top] - hull[i]);
    if (area < best_area) {
      best_area = area;
      best_side = side;
    }
  }
  return best_side;
}

}  // namespace cousin::geometry
