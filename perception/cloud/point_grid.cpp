#include "perception/cloud/point_grid.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace cousin {

PointGrid::PointGrid(std::span<const Eigen::Vector3f> points_m, double side_m)
    : points_m_(points_m), side_m_(side_m) {
  if (!points_m.empty()) origin_m_ = points_m.front();
  entries_.reserve(points_m.size());
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    entries_.push_back({cell(points_m[i]), static_cast<std::uint32_t>(i)});
  }
  std::sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) {
    return a.cell != b.cell ? a.cell < b.cell : a.index < b.index;
  });
}

PointGrid::Cell PointGrid::cell(const Eigen::Vector3f& point_m) const {
  const Eigen::Vector3d scaled = (point_m - origin_m_).cast<double>() / side_m_;
  const Eigen::Vector3d bounded = scaled.array().floor().max(-0x1p30).min(0x1p30);
  return {static_cast<std::int32_t>(bounded.x()), static_cast<std::int32_t>(bounded.y()),
          static_cast<std::int32_t>(bounded.z())};
}

PointGrid::Range PointGrid::range(const Cell& first, const Cell& last) const {
  const auto before = [](const Entry& e, const Cell& c) { return e.cell < c; };
  const auto begin = std::lower_bound(entries_.begin(), entries_.end(), first, before);
  auto end = begin;
  while (end != entries_.end() && end->cell <= last) ++end;
  return {static_cast<std::size_t>(begin - entries_.begin()),
          static_cast<std::size_t>(end - entries_.begin())};
}

std::vector<int> euclidean_groups(std::span<const Eigen::Vector3f> points_m, double distance_m) {
  const PointGrid grid(points_m, distance_m);
  std::vector<std::size_t> parent(points_m.size());
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto root = [&](std::size_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    grid.for_neighbours(points_m[i], [&](std::size_t other) {
      const std::size_t a = root(i), b = root(other);
      if (a != b) parent[std::max(a, b)] = std::min(a, b);  // the root is the group's first point
    });
  }
  std::vector<int> group(points_m.size(), -1);
  int count = 0;
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    const std::size_t r = root(i);
    if (r == i) group[i] = count++;
    group[i] = group[r];
  }
  return group;
}

}  // namespace cousin
