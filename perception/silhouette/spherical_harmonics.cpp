#include "perception/silhouette/spherical_harmonics.h"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace cousin {

RealHarmonics::RealHarmonics(int degree) : degree_(degree) {
  if (degree < 0 || degree > 64) {
    throw std::invalid_argument("degree = " + std::to_string(degree) + " is outside [0, 64]");
  }
  const std::size_t size = static_cast<std::size_t>(count());
  a_.assign(size, 0);
  b_.assign(size, 0);
  for (int l = 0; l <= degree; ++l) {
    for (int m = 0; m < l; ++m) {
      const double l2 = l * l, m2 = m * m, before2 = (l - 1) * (l - 1);
      const std::size_t i = static_cast<std::size_t>(l * (degree + 1) + m);
      a_[i] = std::sqrt((4 * l2 - 1) / (l2 - m2));
      b_[i] = l >= m + 2 ? std::sqrt((before2 - m2) / (4 * before2 - 1)) : 0;
    }
  }
}

void RealHarmonics::evaluate(const Eigen::Vector3d& unit, Eigen::Ref<Eigen::VectorXd> out) const {
  // P_lm without its factor sin^m(theta): that is in (x + i y)^m = cosine + i sine.
  double diagonal = std::sqrt(1 / (4 * std::numbers::pi));
  double cosine = 1, sine = 0;
  for (int m = 0; m <= degree_; ++m) {
    if (m > 0) {
      diagonal *= std::sqrt((2.0 * m + 1) / (2.0 * m));
      const double next = cosine * unit.x() - sine * unit.y();
      sine = cosine * unit.y() + sine * unit.x();
      cosine = next;
    }
    const double factor = m == 0 ? 1 : std::numbers::sqrt2;
    double before = 0, value = diagonal;
    for (int l = m; l <= degree_; ++l) {
      if (l > m) {
        const std::size_t i = static_cast<std::size_t>(l * (degree_ + 1) + m);
        const double next = a_[i] * (unit.z() * value - b_[i] * before);
        before = value;
        value = next;
      }
      const int centre = l * l + l;
      out[centre + m] = factor * value * cosine;
      if (m > 0) out[centre - m] = factor * value * sine;
    }
  }
}

}  // namespace cousin
