#include "sim/geometry/harmonic_radii.h"

#include <algorithm>
#include <cmath>

namespace cousin {

std::vector<double> harmonic_radii(const std::vector<Eigen::Vector3d>& directions, int degrees,
                                   double strength, Rng rng) {
  std::vector<double> coefficients;
  for (int l = 2; l <= degrees; ++l) {
    for (int m = -l; m <= l; ++m) coefficients.push_back(strength / (l * l) * normal(rng));
  }
  std::vector<double> radii;
  radii.reserve(directions.size());
  for (const Eigen::Vector3d& d : directions) {
    const double theta = std::acos(std::clamp(d.z(), -1.0, 1.0));
    const double phi = std::atan2(d.y(), d.x());
    double radius = 1;
    std::size_t k = 0;
    for (int l = 2; l <= degrees; ++l) {
      for (int m = -l; m <= l; ++m) {
        const auto order = static_cast<unsigned>(std::abs(m));
        const double legendre = std::sph_legendre(static_cast<unsigned>(l), order, theta);
        const double turn = m < 0 ? std::sqrt(2) * std::sin(-m * phi)
                                  : (m > 0 ? std::sqrt(2) * std::cos(m * phi) : 1);
        radius += coefficients[k++] * legendre * turn;
      }
    }
    radii.push_back(std::max(0.3, radius));
  }
  return radii;
}

}  // namespace cousin
