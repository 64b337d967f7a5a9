#pragma once

#include <Eigen/Core>
#include <vector>

namespace cousin {

/// Real spherical harmonics Y_lm, orthonormal on the unit sphere, for l <= degree. Index l * l + l
/// + m; m < 0 are the sines. By recurrences on Cartesian coordinates: no angles, so no trouble at
/// the poles.
class RealHarmonics {
 public:
  /// @throws std::invalid_argument unless 0 <= degree <= 64.
  explicit RealHarmonics(int degree);

  int degree() const { return degree_; }
  int count() const { return (degree_ + 1) * (degree_ + 1); }
  /// All values at a unit vector into `out`, count() long.
  void evaluate(const Eigen::Vector3d& unit, Eigen::Ref<Eigen::VectorXd> out) const;

 private:
  int degree_;
  std::vector<double> a_, b_;  ///< of the Legendre recurrence in l, [l * (degree + 1) + m]
};

}  // namespace cousin
