#include "perception/splats/near_points.h"

#include <algorithm>
#include <numeric>

namespace cousin {
namespace {

constexpr std::size_t kLeaf = 8;  ///< points that are tested one by one

}  // namespace

struct NearPoints::Search {
  std::size_t index;
  std::size_t count;
  std::vector<double> nearest;  ///< ascending

  void offer(double distance2) {
    if (nearest.size() == count && distance2 >= nearest.back()) return;
    if (nearest.size() == count) nearest.pop_back();
    nearest.insert(std::upper_bound(nearest.begin(), nearest.end(), distance2), distance2);
  }
  bool wants(double distance2) const {
    return nearest.size() < count || distance2 < nearest.back();
  }
};

NearPoints::NearPoints(std::span<const Eigen::Vector3d> points_m)
    : points_m_(points_m), order_(points_m.size()), axis_(points_m.size()) {
  std::iota(order_.begin(), order_.end(), 0u);
  build(0, order_.size());
}

void NearPoints::build(std::size_t begin, std::size_t end) {
  if (end - begin <= kLeaf) return;
  Eigen::Vector3d low = points_m_[order_[begin]];
  Eigen::Vector3d high = low;
  for (std::size_t i = begin; i < end; ++i) {
    low = low.cwiseMin(points_m_[order_[i]]);
    high = high.cwiseMax(points_m_[order_[i]]);
  }
  int axis = 0;
  (high - low).maxCoeff(&axis);
  const std::size_t middle = begin + (end - begin) / 2;
  const auto at = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(begin), at(middle), at(end), [&](std::uint32_t a, std::uint32_t b) {
    return points_m_[a][axis] < points_m_[b][axis];
  });
  axis_[middle] = static_cast<std::uint8_t>(axis);
  build(begin, middle);
  build(middle + 1, end);
}

void NearPoints::visit(std::size_t begin, std::size_t end, Search& search) const {
  const Eigen::Vector3d& point = points_m_[search.index];
  const auto test = [&](std::size_t i) {
    if (order_[i] != search.index) search.offer((points_m_[order_[i]] - point).squaredNorm());
  };
  if (end - begin <= kLeaf) {
    for (std::size_t i = begin; i < end; ++i) test(i);
    return;
  }
  const std::size_t middle = begin + (end - begin) / 2;
  const int axis = axis_[middle];
  const double beyond = point[axis] - points_m_[order_[middle]][axis];
  test(middle);
  if (beyond < 0) {
    visit(begin, middle, search);
    if (search.wants(beyond * beyond)) visit(middle + 1, end, search);
  } else {
    visit(middle + 1, end, search);
    if (search.wants(beyond * beyond)) visit(begin, middle, search);
  }
}

std::vector<double> NearPoints::squared_distances_m2(std::size_t index, std::size_t count) const {
  Search search{index, count, {}};
  if (count == 0) return {};
  search.nearest.reserve(count + 1);
  visit(0, order_.size(), search);
  return search.nearest;
}

}  // namespace cousin
