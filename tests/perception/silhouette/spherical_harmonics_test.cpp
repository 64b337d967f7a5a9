#include "perception/silhouette/spherical_harmonics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/types/rng.h"

namespace cousin {
namespace {

TEST(RealHarmonics, AdditionTheoremHolds) {
  // sum_m Y_lm(u) Y_lm(v) = (2 l + 1) / (4 pi) P_l(u . v): fixes norm and orthogonality for every
  // degree.
  constexpr int kDegree = 20;
  const RealHarmonics harmonics(kDegree);
  Rng rng(4);
  Eigen::VectorXd a(harmonics.count()), b(harmonics.count());
  for (int trial = 0; trial < 20; ++trial) {
    Eigen::Vector3d u(normal(rng), normal(rng), normal(rng)),
        v(normal(rng), normal(rng), normal(rng));
    u.normalize();
    v.normalize();
    if (trial == 0) u = Eigen::Vector3d::UnitZ();
    harmonics.evaluate(u, a);
    harmonics.evaluate(v, b);
    for (int l = 0; l <= kDegree; ++l) {
      const double sum = a.segment(l * l, 2 * l + 1).dot(b.segment(l * l, 2 * l + 1));
      const double expected =
          (2 * l + 1) / (4 * std::numbers::pi) * std::legendre(static_cast<unsigned>(l), u.dot(v));
      EXPECT_NEAR(sum, expected, 1e-12 * (2 * l + 1));  // some hundred roundings
    }
  }
}

TEST(RealHarmonics, DegreeOutOfRangeIsRefused) {
  EXPECT_THROW(RealHarmonics(-1), std::invalid_argument);
  EXPECT_THROW(RealHarmonics(65), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
