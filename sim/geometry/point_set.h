#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

namespace cousin::geometry {

/// Private to sim/geometry. Points as three arrays, padded to a multiple of eight with copies of
/// the first, so that extents along a direction are computed eight at a time.
class PointSet {
 public:
  void reserve(std::size_t count);
  void add(double x, double y, double z);
  void pad();  ///< call after the last `add`
  std::size_t size() const { return count_; }
  Eigen::Vector3d operator[](std::size_t i) const { return {x_[i], y_[i], z_[i]}; }

  struct Extent {
    double low = 0, high = 0;
    double width() const { return high - low; }
  };
  Extent extent(const Eigen::Vector3d& direction) const;
  /// Indices of the lowest and highest point along a direction.
  struct Extremes {
    std::size_t low = 0, high = 0;
  };
  Extremes extremes(const Eigen::Vector3d& direction) const;

 private:
  std::size_t count_ = 0;
  std::vector<double> x_, y_, z_;
};

/// @throws std::invalid_argument if there are none or one is not finite (NaN, infinite).
void check_points(std::span<const Eigen::Vector3d> points_m);

/// Which flat the points lie in, to a relative tolerance of their extent and the rounding of their
/// coordinates.
struct Flat {
  int dimension = 0;                                   ///< 0 a point, 1 a line, 2 a plane, 3 space
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();  ///< middle of the axis-parallel bounds
  double extent_m = 0;                                 ///< largest side of those bounds
  Eigen::Matrix3d axes =
      Eigen::Matrix3d::Identity();  ///< columns: the flat's directions first; right-handed
};
Flat find_flat(std::span<const Eigen::Vector3d> points_m, double tolerance = 1e-12);

}  // namespace cousin::geometry
