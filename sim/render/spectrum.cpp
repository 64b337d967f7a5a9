#include "sim/render/spectrum.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace cousin {
namespace {

constexpr double kShortest_m = 360e-9, kLongest_m = 830e-9, kStep_m = 1e-9;

double lobe(double nm, double peak, double below, double above) {
  const double t = (nm - peak) / (nm < peak ? below : above);
  return std::exp(-0.5 * t * t);
}

}  // namespace

Eigen::Vector3d cie_xyz(double wavelength_m) {
  const double nm = wavelength_m * 1e9;
  return {1.056 * lobe(nm, 599.8, 37.9, 31.0) + 0.362 * lobe(nm, 442.0, 16.0, 26.7) -
              0.065 * lobe(nm, 501.1, 20.4, 26.2),
          0.821 * lobe(nm, 568.8, 46.9, 40.5) + 0.286 * lobe(nm, 530.9, 16.3, 31.1),
          1.217 * lobe(nm, 437.0, 11.8, 36.0) + 0.681 * lobe(nm, 459.0, 26.0, 13.8)};
}

Eigen::Vector3d linear_srgb(const Eigen::Vector3d& xyz) {
  // IEC 61966-2-1.
  return {3.2406 * xyz.x() - 1.5372 * xyz.y() - 0.4986 * xyz.z(),
          -0.9689 * xyz.x() + 1.8758 * xyz.y() + 0.0415 * xyz.z(),
          0.0557 * xyz.x() - 0.2040 * xyz.y() + 1.0570 * xyz.z()};
}

Eigen::Vector3d xyz_of(const std::function<double(double)>& spectrum_per_m) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  const int steps = static_cast<int>(std::lround((kLongest_m - kShortest_m) / kStep_m));
  for (int i = 0; i <= steps; ++i) {
    const double wavelength_m = kShortest_m + kStep_m * i;
    const double weight = i == 0 || i == steps ? 0.5 : 1;
    sum += weight * kStep_m * spectrum_per_m(wavelength_m) * cie_xyz(wavelength_m);
  }
  return sum;
}

Rgbf led_color(std::span<const LedPeak> peaks) {
  if (peaks.empty()) throw std::invalid_argument("lamp spectrum: no peaks");
  for (const LedPeak& peak : peaks) {
    if (!(peak.wavelength_m >= kShortest_m && peak.wavelength_m <= kLongest_m)) {
      throw std::invalid_argument(
          "lamp spectrum: wavelength_m = " + std::to_string(peak.wavelength_m * 1e9) +
          " nm is not in 360..830 nm");
    }
    if (!(peak.fwhm_m >= 1e-9 && peak.fwhm_m <= 1e-6) || !(peak.power > 0 && peak.power < 1e12)) {
      throw std::invalid_argument(
          "lamp spectrum: fwhm_m must be in [1e-9, 1e-6], power in (0, 1e12)");
    }
  }
  const Eigen::Vector3d xyz = xyz_of([&](double wavelength_m) {
    double sum = 0;
    for (const LedPeak& peak : peaks) {
      const double sigma_m = peak.fwhm_m / 2.3548200450309493;
      const double t = (wavelength_m - peak.wavelength_m) / sigma_m;
      sum += peak.power * std::exp(-0.5 * t * t) / sigma_m;
    }
    return sum;
  });
  Eigen::Vector3d rgb = linear_srgb(xyz / xyz.y());
  const double lowest = rgb.minCoeff();
  if (lowest < 0) {
    // White of the same luminance is (1, 1, 1): mix in the share that lifts the lowest part to 0.
    const double white = -lowest / (1 - lowest);
    rgb = (1 - white) * rgb + Eigen::Vector3d::Constant(white);
  }
  rgb = rgb.cwiseMax(0.0);
  return {static_cast<float>(rgb.x()), static_cast<float>(rgb.y()), static_cast<float>(rgb.z())};
}

}  // namespace cousin
