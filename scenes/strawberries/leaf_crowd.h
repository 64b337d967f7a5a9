#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "sim/types/mesh.h"

namespace cousin {

/// Private to scenes/strawberries. Leaflets that stand, in a grid, for asking whether another one
/// would pass through them: leaves lie against each other but do not cross.
class LeafCrowd {
 public:
  /// Whether any triangle of `leaflet`, moved by `at_m`, meets one that stands.
  bool is_crossed_by(const Mesh& leaflet, const Eigen::Vector3d& at_m) const;
  void add(const Mesh& leaflet, const Eigen::Vector3d& at_m);

 private:
  using Corners = std::array<Eigen::Vector3d, 3>;
  std::vector<Corners> triangles_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;
};

}  // namespace cousin
