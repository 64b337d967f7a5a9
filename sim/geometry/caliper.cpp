#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <numeric>

#include "sim/geometry/hull_graph.h"
#include "sim/geometry/measure.h"
#include "sim/geometry/point_set.h"

namespace cousin {
namespace {

using geometry::Hull;

/// Largest distance between two points: pairs in order of their distance from the middle, until
/// none can be longer.
double largest_distance(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) middle += p / static_cast<double>(points.size());
  std::vector<std::pair<double, std::size_t>> order;
  order.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    order.emplace_back((points[i] - middle).norm(), i);
  std::sort(order.begin(), order.end(),
            [](const auto& a, const auto& b) { return a.first > b.first; });
  double best = 0;
  for (std::size_t i = 0; i < order.size() && 2 * order[i].first > best; ++i) {
    for (std::size_t j = i + 1; j < order.size() && order[i].first + order[j].first > best; ++j) {
      best = std::max(best, (points[order[i].second] - points[order[j].second]).norm());
    }
  }
  return best;
}

/// Neighbours of each vertex along the hull's edges.
class VertexGraph {
 public:
  explicit VertexGraph(const Hull& hull)
      : points_(hull.vertices), first_(hull.vertices.size() + 1) {
    for (const auto& t : hull.triangles) {
      for (const std::uint32_t v : t) ++first_[v + 1];
    }
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    others_.resize(first_.back());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for (const auto& t : hull.triangles) {
      for (std::size_t k = 0; k < 3; ++k) others_[next[t[k]]++] = t[(k + 1) % 3];
    }
  }
  std::span<const std::uint32_t> around(std::uint32_t v) const {
    return {others_.data() + first_[v], first_[v + 1] - first_[v]};
  }
  /// Lowest vertex along `direction`, downhill from `start`: on a convex polytope no other valley
  /// exists.
  std::uint32_t lowest(const Eigen::Vector3d& direction, std::uint32_t start) const {
    double height = direction.dot(points_[start]);
    while (true) {
      std::uint32_t next = start;
      for (const std::uint32_t v : around(start)) {
        const double h = direction.dot(points_[v]);
        if (h < height) {
          height = h;
          next = v;
        }
      }
      if (next == start) return start;
      start = next;
    }
  }

 private:
  const std::vector<Eigen::Vector3d>& points_;
  std::vector<std::size_t> first_;
  std::vector<std::uint32_t> others_;
};

/// Smallest width of the polytope. It is reached between a face and a vertex or between two edges
/// [Houle & Toussaint 1988]. For each edge the direction turns from one face's normal to the
/// other's, u(t) = (1 - t) n1 + t n2, while the lowest vertex a is followed: each change a -> b,
/// where u . (b - a) = 0, is a pair of edges.
class Width {
 public:
  explicit Width(const Hull& hull) : hull_(hull), graph_(hull) {}

  double smallest() {
    // Triangles in the order of a walk over the hull keep the next search close to the last.
    std::vector<std::uint32_t> lowest(hull_.triangles.size());
    std::vector<bool> seen(hull_.triangles.size());
    std::vector<std::uint32_t> todo = {0};
    seen[0] = true;
    std::uint32_t last = 0;
    while (!todo.empty()) {
      const std::uint32_t t = todo.back();
      todo.pop_back();
      last = lowest[t] = graph_.lowest(hull_.normals[t], last);
      consider(hull_.normals[t], hull_.triangles[t][0], last);
      for (const std::uint32_t n : hull_.beside[t]) {
        if (!seen[n]) todo.push_back(n);
        seen[n] = true;
      }
    }
    for (std::uint32_t t = 0; t < hull_.triangles.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) {
        if (t < hull_.beside[t][k]) follow(t, hull_.beside[t][k], hull_.triangles[t][k], lowest[t]);
      }
    }
    return best_;
  }

 private:
  void consider(const Eigen::Vector3d& direction, std::uint32_t high, std::uint32_t low) {
    const double length = direction.norm();
    if (!(length > 0)) return;
    best_ = std::min(best_, direction.dot(hull_.vertices[high] - hull_.vertices[low]) / length);
  }

  void follow(std::uint32_t from, std::uint32_t to, std::uint32_t on_edge, std::uint32_t low) {
    const Eigen::Vector3d& n1 = hull_.normals[from];
    const Eigen::Vector3d turn = hull_.normals[to] - n1;
    double t = 0;
    for (std::size_t step = 0; step < hull_.vertices.size(); ++step) {
      double next_t = 1;
      std::uint32_t next = low;
      for (const std::uint32_t v : graph_.around(low)) {
        const Eigen::Vector3d d = hull_.vertices[v] - hull_.vertices[low];
        const double rate = turn.dot(d);
        if (!(rate < 0)) continue;  // v does not sink below `low`
        const double at = std::max(t, -n1.dot(d) / rate);
        if (at < next_t) {
          next_t = at;
          next = v;
        }
      }
      if (next == low) return;
      t = next_t;
      low = next;
      consider(n1 + t * turn, on_edge, low);
    }
  }

  const Hull& hull_;
  VertexGraph graph_;
  double best_ = std::numeric_limits<double>::infinity();
};

}  // namespace

CaliperDiameters caliper_diameters(std::span<const Eigen::Vector3d> points_m) {
  geometry::check_points(points_m);
  const Hull hull = geometry::build_hull(points_m);
  if (!hull.triangles.empty()) return {largest_distance(hull.vertices), Width(hull).smallest()};
  // Flat: no width. In a plane the largest distance is between corners of the flat box's outline;
  // all points will do.
  const Eigen::Vector3d origin = points_m.front();
  std::vector<Eigen::Vector3d> local;
  local.reserve(points_m.size());
  for (const Eigen::Vector3d& p : points_m) local.push_back(p - origin);
  return {largest_distance(local), 0};
}

}  // namespace cousin
