#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

#include "perception/cloud/clusters.h"

namespace cousin {
namespace {

constexpr double kCellM = 0.0003;
/// One seed's footprint covers this much of its hull; two that touch leave a waist.
constexpr double kLeastSolidity = 0.88;

using Cell = std::pair<int, int>;

double cross(const Cell& o, const Cell& a, const Cell& b) {
  return static_cast<double>(a.first - o.first) * (b.second - o.second) -
         static_cast<double>(a.second - o.second) * (b.first - o.first);
}

/// Area of the convex hull of the cells' corners, in cells [Andrew's monotone chain].
double hull_area(const std::vector<Cell>& cells) {
  std::vector<Cell> corners;
  for (const Cell& c : cells) {
    for (const int dx : {0, 1}) {
      for (const int dy : {0, 1}) corners.emplace_back(c.first + dx, c.second + dy);
    }
  }
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  std::vector<Cell> hull;
  for (int side = 0; side < 2; ++side) {
    const std::size_t start = hull.size();
    for (const Cell& c : corners) {
      while (hull.size() >= start + 2 && cross(hull[hull.size() - 2], hull.back(), c) <= 0)
        hull.pop_back();
      hull.push_back(c);
    }
    hull.pop_back();
    std::reverse(corners.begin(), corners.end());
  }
  double twice = 0;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Cell &a = hull[i], &b = hull[(i + 1) % hull.size()];
    twice += static_cast<double>(a.first) * b.second - static_cast<double>(b.first) * a.second;
  }
  return 0.5 * std::abs(twice);
}

/// Cells covered in every row from the first to the last point: fills holes that matching left
/// inside.
std::vector<Cell> filled(const std::vector<Cell>& cells, bool by_rows) {
  std::map<int, std::pair<int, int>> span;
  for (const Cell& c : cells) {
    const int line = by_rows ? c.second : c.first, at = by_rows ? c.first : c.second;
    const auto [found, added] = span.try_emplace(line, at, at);
    found->second = {std::min(found->second.first, at), std::max(found->second.second, at)};
  }
  std::vector<Cell> result;
  for (const auto& [line, ends] : span) {
    for (int at = ends.first; at <= ends.second; ++at) {
      result.push_back(by_rows ? Cell(at, line) : Cell(line, at));
    }
  }
  std::sort(result.begin(), result.end());
  return result;
}

ClusterShape shape_of(const std::vector<Eigen::Vector2d>& points_m) {
  ClusterShape shape;
  shape.points = static_cast<int>(points_m.size());
  if (points_m.empty()) return shape;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const auto& p : points_m) mean += p / static_cast<double>(points_m.size());
  Eigen::Matrix2d moments = Eigen::Matrix2d::Zero();
  for (const auto& p : points_m) moments += (p - mean) * (p - mean).transpose();
  // Along the long axis, so that a waist shows as short lines across.
  const Eigen::Matrix2d axes =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(moments).eigenvectors();
  std::vector<Cell> cells;
  for (const auto& p : points_m) {
    const Eigen::Vector2d q = axes.transpose() * (p - mean) / kCellM;
    cells.emplace_back(static_cast<int>(std::floor(q.x())), static_cast<int>(std::floor(q.y())));
  }
  const std::vector<Cell> rows = filled(cells, true), columns = filled(cells, false);
  std::vector<Cell> both;
  std::set_intersection(rows.begin(), rows.end(), columns.begin(), columns.end(),
                        std::back_inserter(both));
  shape.footprint_m2 = static_cast<double>(both.size()) * kCellM * kCellM;
  shape.solidity = std::min(1.0, static_cast<double>(both.size()) / hull_area(cells));
  shape.may_be_several = shape.solidity < kLeastSolidity;
  return shape;
}

}  // namespace

std::vector<ClusterShape> cluster_shapes(const Clusters& clusters) {
  std::vector<std::vector<Eigen::Vector2d>> points_m(static_cast<std::size_t>(clusters.count));
  for (std::size_t i = 0; i < clusters.cloud.size(); ++i) {
    if (clusters.instance[i] < 0) continue;
    points_m.at(static_cast<std::size_t>(clusters.instance[i]))
        .push_back(clusters.cloud[i].position_m.head<2>().cast<double>());
  }
  std::vector<ClusterShape> shapes;
  for (const auto& points : points_m) shapes.push_back(shape_of(points));
  return shapes;
}

}  // namespace cousin
