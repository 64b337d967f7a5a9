#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

namespace cousin {

/// A k-d tree over points [Bentley 1975], for the nearest others of each.
class NearPoints {
 public:
  /// `points_m` must be finite and outlive this.
  explicit NearPoints(std::span<const Eigen::Vector3d> points_m);

  /// Squared distances from point `index` to its nearest `count` others, the least first; fewer if
  /// there are fewer points. Points in the same place count.
  std::vector<double> squared_distances_m2(std::size_t index, std::size_t count) const;

 private:
  struct Search;
  void build(std::size_t begin, std::size_t end);
  void visit(std::size_t begin, std::size_t end, Search& search) const;

  std::span<const Eigen::Vector3d> points_m_;
  std::vector<std::uint32_t> order_;
  std::vector<std::uint8_t> axis_;  ///< along which the range whose middle this is was split
};

}  // namespace cousin
