#include "sim/render/clear_sky.h"

#include <algorithm>
#include <cmath>

#include "sim/render/spectrum.h"
#include "sim/truth/scene_check.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {

constexpr double kLumensPerWatt = 683.002;

/// Spectral irradiance of the sun outside the air, W/m^2 per metre of wavelength: a black body of
/// 5778 K and 6.807e-5 sr.
double sun_outside(double wavelength_m) {
  constexpr double kH = 6.62607015e-34, kC = 299792458, kBoltzmann = 1.380649e-23;
  const double radiance = 2 * kH * kC * kC / std::pow(wavelength_m, 5) /
                          std::expm1(kH * kC / (wavelength_m * kBoltzmann * 5778));
  return 6.807e-5 * radiance;
}

/// Ozone's Chappuis band as one Gaussian: 0.125 per cm at 602 nm [the table of Preetham et al.].
double ozone_per_cm(double wavelength_m) {
  const double t = (wavelength_m - 602e-9) / 45e-9;
  return 0.125 * std::exp(-0.5 * t * t);
}

}  // namespace

double clear_air_transmittance(const ClearSky& sky, double wavelength_m) {
  const double cosine = std::clamp(sky.to_sun.normalized().z(), 0.0, 1.0);
  const double degrees = std::acos(cosine) * 180 / kPi;
  const double air_mass = 1 / (cosine + 0.15 * std::pow(std::max(93.885 - degrees, 1.0), -1.253));
  const double um = wavelength_m * 1e6;
  const double beta = 0.04608 * sky.turbidity - 0.04586;
  return std::exp(-air_mass * (0.008735 * std::pow(um, -4.08) + beta * std::pow(um, -1.3) +
                               0.35 * ozone_per_cm(wavelength_m)));
}

ClearSkyModel::ClearSkyModel(const ClearSky& sky) : scale_(sky.scale) {
  validate(Light(sky), "sky");
  to_sun_ = sky.to_sun.normalized();
  const double t = sky.turbidity;
  const double theta = std::acos(std::clamp(to_sun_.z(), -1.0, 1.0));
  coefficients_ << 0.1787 * t - 1.4630, -0.3554 * t + 0.4275, -0.0227 * t + 5.3251,
      0.1206 * t - 2.5771, -0.0670 * t + 0.3703,  //
      -0.0193 * t - 0.2592, -0.0665 * t + 0.0008, -0.0004 * t + 0.2125, -0.0641 * t - 0.8989,
      -0.0033 * t + 0.0452,  //
      -0.0167 * t - 0.2608, -0.0950 * t + 0.0092, -0.0079 * t + 0.2102, -0.0441 * t - 1.6537,
      -0.0109 * t + 0.0529;
  Eigen::Matrix<double, 3, 4> x, y;
  x << 0.00166, -0.00375, 0.00209, 0, -0.02903, 0.06377, -0.03202, 0.00394, 0.11693, -0.21196,
      0.06052, 0.25886;
  y << 0.00275, -0.00610, 0.00317, 0, -0.04214, 0.08970, -0.04153, 0.00516, 0.15346, -0.26756,
      0.06670, 0.26688;
  const Eigen::RowVector3d powers(t * t, t, 1);
  const Eigen::Vector4d angles(theta * theta * theta, theta * theta, theta, 1);
  const double chi = (4.0 / 9 - t / 120) * (kPi - 2 * theta);
  zenith_ = {(4.0453 * t - 4.9710) * std::tan(chi) - 0.2155 * t + 2.4192, powers * x * angles,
             powers * y * angles};
  zenith_.x() = std::max(zenith_.x(), 0.0);
  for (int k = 0; k < 3; ++k) norm_[k] = perez(k, 1, theta);

  if (sky.has_sun) {
    const Eigen::Vector3d xyz =
        kLumensPerWatt * xyz_of([&](double wavelength_m) {
          return sun_outside(wavelength_m) * clear_air_transmittance(sky, wavelength_m);
        });
    sun_irradiance_ = (scale_ * 1e-3 * linear_srgb(xyz)).cwiseMax(0.0);  // kilolux
  }
  // Level ground: midpoint rule in the squared sine of the zenith angle, where the cosine is even.
  constexpr int kRings = 64, kSectors = 128;
  for (int i = 0; i < kRings; ++i) {
    const double sine = std::sqrt((i + 0.5) / kRings), cosine = std::sqrt(1 - sine * sine);
    for (int j = 0; j < kSectors; ++j) {
      const double azimuth = 2 * kPi * (j + 0.5) / kSectors;
      horizontal_irradiance_ +=
          kPi / (kRings * kSectors) *
          radiance({sine * std::cos(azimuth), sine * std::sin(azimuth), cosine});
    }
  }
  horizontal_irradiance_ += sun_irradiance_ * to_sun_.z();
}

double ClearSkyModel::perez(int k, double cosine, double angle_rad) const {
  const auto c = coefficients_.row(k);
  const double cos_angle = std::cos(angle_rad);
  return (1 + c[0] * std::exp(c[1] / std::max(cosine, 0.01))) *
         (1 + c[2] * std::exp(c[3] * angle_rad) + c[4] * cos_angle * cos_angle);
}

Eigen::Vector3d ClearSkyModel::radiance(const Eigen::Vector3d& direction) const {
  const double angle = std::acos(std::clamp(direction.dot(to_sun_), -1.0, 1.0));
  const double cosine = std::max(direction.z(), 0.0);
  Eigen::Vector3d v;
  for (int k = 0; k < 3; ++k) v[k] = zenith_[k] * perez(k, cosine, angle) / norm_[k];
  const double scaled = scale_ * std::max(v.x(), 0.0);
  const double y = std::max(v.z(), 1e-3);
  return (scaled * linear_srgb({v.y() / y, 1, (1 - v.y() - y) / y})).cwiseMax(0.0);
}

}  // namespace cousin
