#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace cousin {

/// Points in cubes of one side, for neighbours within that side. Points must be finite and lie
/// within 2^30 sides of the first.
class PointGrid {
 public:
  PointGrid(std::span<const Eigen::Vector3f> points_m, double side_m);

  /// Calls visit(index) for every point within the side of `point_m`, by cell, then by index.
  template <class Visit>
  void for_neighbours(const Eigen::Vector3f& point_m, const Visit& visit) const {
    const Cell centre = cell(point_m);
    const float limit = static_cast<float>(side_m_ * side_m_);
    for (std::int32_t dx = -1; dx <= 1; ++dx) {
      for (std::int32_t dy = -1; dy <= 1; ++dy) {
        // Cells along z follow each other in the order, so one search finds all three.
        const auto [begin, end] = range({centre[0] + dx, centre[1] + dy, centre[2] - 1},
                                        {centre[0] + dx, centre[1] + dy, centre[2] + 1});
        for (std::size_t i = begin; i < end; ++i) {
          const std::size_t other = entries_[i].index;
          if ((points_m_[other] - point_m).squaredNorm() <= limit) visit(other);
        }
      }
    }
  }

 private:
  using Cell = std::array<std::int32_t, 3>;
  struct Entry {
    Cell cell;
    std::uint32_t index;
  };
  struct Range {
    std::size_t begin, end;
  };
  Cell cell(const Eigen::Vector3f& point_m) const;
  Range range(const Cell& first, const Cell& last) const;

  std::span<const Eigen::Vector3f> points_m_;
  double side_m_;
  Eigen::Vector3f origin_m_ = Eigen::Vector3f::Zero();
  std::vector<Entry> entries_;  ///< by cell, then index
};

/// Groups of points linked by steps of at most `distance_m`; a number for each point, counting from
/// 0 in the order of each group's first point.
std::vector<int> euclidean_groups(std::span<const Eigen::Vector3f> points_m, double distance_m);

}  // namespace cousin
