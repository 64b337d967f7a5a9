#include "sim/geometry/surface_crossing.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <set>
#include <stdexcept>
#include <string>

namespace cousin {
namespace {

using Eigen::Vector3d;
using Triangle = std::array<Vector3d, 3>;
using Box = Eigen::AlignedBox3d;

bool passes_through(const Vector3d& from, const Vector3d& to, const Triangle& t) {
  const Vector3d way = to - from, e1 = t[1] - t[0], e2 = t[2] - t[0];
  const Vector3d p = way.cross(e2);
  const double det = e1.dot(p);
  if (det == 0) return false;
  const Vector3d s = from - t[0];
  const double u = s.dot(p) / det;
  if (!(u >= 0 && u <= 1)) return false;
  const Vector3d q = s.cross(e1);
  const double v = way.dot(q) / det;
  if (!(v >= 0 && u + v <= 1)) return false;
  const double along = e2.dot(q) / det;
  return along >= 0 && along <= 1;
}

double area_m2(const Triangle& t) { return 0.5 * (t[1] - t[0]).cross(t[2] - t[0]).norm(); }

Box box_of(const Triangle& t) {
  Box box(t[0]);
  box.extend(t[1]);
  box.extend(t[2]);
  return box;
}

/// Triangles in a tree of boxes, halved at the median of the longest side.
class BoxTree {
 public:
  explicit BoxTree(std::vector<Box> boxes) : boxes_(std::move(boxes)), order_(boxes_.size()) {
    std::iota(order_.begin(), order_.end(), 0U);
    if (!order_.empty()) build(0, order_.size());
  }

  template <class Visit>
  void visit(const Box& box, const Visit& found) const {
    std::vector<std::size_t> todo;
    if (!nodes_.empty()) todo.push_back(0);
    while (!todo.empty()) {
      const Node& node = nodes_[todo.back()];
      todo.pop_back();
      if (!node.box.intersects(box)) continue;
      if (node.right == 0) {
        for (std::size_t i = node.begin; i < node.end; ++i) {
          if (boxes_[order_[i]].intersects(box)) found(order_[i]);
        }
      } else {
        todo.push_back(node.left);
        todo.push_back(node.right);
      }
    }
  }

 private:
  struct Node {
    Box box;
    std::size_t begin = 0, end = 0;
    std::size_t left = 0, right = 0;  ///< 0 = a leaf of the tree
  };

  std::size_t build(std::size_t begin, std::size_t end) {
    constexpr std::size_t kFew = 8;
    const std::size_t place = nodes_.size();
    nodes_.push_back({{}, begin, end});
    Box box;
    for (std::size_t i = begin; i < end; ++i) box.extend(boxes_[order_[i]]);
    nodes_[place].box = box;
    if (end - begin <= kFew) return place;
    Eigen::Index axis = 0;
    box.sizes().maxCoeff(&axis);
    const std::size_t middle = (begin + end) / 2;
    const auto at = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle), at(end), [&](std::uint32_t a, std::uint32_t b) {
      const double ca = boxes_[a].center()[axis], cb = boxes_[b].center()[axis];
      return ca != cb ? ca < cb : a < b;
    });
    const std::size_t left = build(begin, middle), right = build(middle, end);
    nodes_[place].left = left;
    nodes_[place].right = right;
    return place;
  }

  std::vector<Box> boxes_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

/// Area of the pieces of a triangle, none with an edge above the resolution, that meet others.
double crossed_area_m2(const Triangle& t, const std::vector<Triangle>& others,
                       double resolution_m) {
  std::vector<Triangle> near;
  const Box box = box_of(t);
  for (const Triangle& other : others) {
    if (box.intersects(box_of(other)) && triangles_meet(t, other)) near.push_back(other);
  }
  if (near.empty()) return 0;
  const double edges_m[3] = {(t[1] - t[0]).norm(), (t[2] - t[1]).norm(), (t[0] - t[2]).norm()};
  const std::size_t k = static_cast<std::size_t>(std::max_element(edges_m, edges_m + 3) - edges_m);
  if (edges_m[k] <= resolution_m) return area_m2(t);
  const Vector3d &a = t[k], &b = t[(k + 1) % 3], &c = t[(k + 2) % 3];
  const Vector3d middle = 0.5 * (a + b);
  return crossed_area_m2({a, middle, c}, near, resolution_m) +
         crossed_area_m2({middle, b, c}, near, resolution_m);
}

}  // namespace

bool triangles_meet(const Triangle& a, const Triangle& b) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (passes_through(a[k], a[(k + 1) % 3], b) || passes_through(b[k], b[(k + 1) % 3], a))
      return true;
  }
  return false;
}

SurfaceCrossing surface_crossing(const Mesh& mesh, std::span<const int> sheet,
                                 double resolution_m) {
  if (sheet.size() != mesh.triangles.size() || !(resolution_m > 0)) {
    throw std::invalid_argument("surface_crossing: " + std::to_string(sheet.size()) +
                                " sheet numbers for " + std::to_string(mesh.triangles.size()) +
                                " triangles, at a resolution of " + std::to_string(resolution_m) +
                                " m; one each is needed, and a resolution above 0");
  }
  std::vector<Triangle> triangles;
  std::vector<int> sheets;
  std::vector<Box> boxes;
  for (std::size_t i = 0; i < sheet.size(); ++i) {
    if (sheet[i] < 0) continue;
    const auto& t = mesh.triangles[i];
    triangles.push_back(
        {mesh.vertices_m.at(t[0]), mesh.vertices_m.at(t[1]), mesh.vertices_m.at(t[2])});
    sheets.push_back(sheet[i]);
    boxes.push_back(box_of(triangles.back()));
  }
  const BoxTree tree(boxes);
  struct Found {
    double crossed_m2 = 0;
    std::vector<int> sheets;
  };
  std::vector<Found> found(triangles.size());
  tbb::parallel_for(std::size_t{0}, triangles.size(), [&](std::size_t i) {
    std::vector<Triangle> others;
    tree.visit(boxes[i], [&](std::uint32_t j) {
      if (sheets[j] == sheets[i] || !triangles_meet(triangles[i], triangles[j])) return;
      others.push_back(triangles[j]);
      found[i].sheets.push_back(sheets[j]);
    });
    if (!others.empty()) found[i].crossed_m2 = crossed_area_m2(triangles[i], others, resolution_m);
  });
  SurfaceCrossing result;
  std::set<std::pair<int, int>> pairs;
  for (std::size_t i = 0; i < triangles.size(); ++i) {  // in order: sums do not depend on threads
    result.area_m2 += area_m2(triangles[i]);
    result.crossed_m2 += found[i].crossed_m2;
    for (const int other : found[i].sheets)
      pairs.insert({std::min(sheets[i], other), std::max(sheets[i], other)});
  }
  result.pairs = static_cast<int>(pairs.size());
  return result;
}

}  // namespace cousin
