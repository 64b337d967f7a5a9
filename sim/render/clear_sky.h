#pragma once

#include <Eigen/Core>

#include "sim/truth/scene.h"

namespace cousin {

/// Share of sunlight of one wavelength that comes through clear air: Rayleigh, aerosol by turbidity
/// and ozone over Kasten's air mass, 36 at the horizon [Preetham, Shirley & Smits 1999, appendix].
/// @param sky  its `to_sun` (any length but zero, z >= 0) and `turbidity` count.
double clear_air_transmittance(const ClearSky& sky, double wavelength_m);

/// Daylight without clouds [Preetham, Shirley & Smits, SIGGRAPH 1999]: luminance and chromaticity
/// by Perez' formula, the sun's irradiance by the air's transmittance over wavelength (Rayleigh,
/// aerosol by turbidity, ozone; the sun as a black body of 5778 K).
class ClearSkyModel {
 public:
  /// @throws std::invalid_argument for a sun below the horizon, a turbidity outside [1.7, 10], an
  /// angular radius outside (0, 0.1], or a scale or albedo that is not finite and >= 0.
  explicit ClearSkyModel(const ClearSky& sky);

  /// Linear sRGB radiance along a unit direction, z >= 0; without the sun's disk.
  Eigen::Vector3d radiance(const Eigen::Vector3d& direction) const;
  /// Linear sRGB irradiance of the sun on a surface facing it; zero if it is switched off.
  const Eigen::Vector3d& sun_irradiance() const { return sun_irradiance_; }
  /// Irradiance of sky and sun on level ground.
  const Eigen::Vector3d& horizontal_irradiance() const { return horizontal_irradiance_; }

 private:
  double perez(int channel, double cosine, double angle_rad) const;

  Eigen::Vector3d to_sun_;
  double scale_;
  Eigen::Matrix<double, 3, 5> coefficients_;  ///< rows Y, x, y; columns A..E
  Eigen::Vector3d zenith_;                    ///< Y [kcd/m^2], x, y
  Eigen::Vector3d norm_;                      ///< Perez' formula at the zenith
  Eigen::Vector3d sun_irradiance_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d horizontal_irradiance_ = Eigen::Vector3d::Zero();
};

}  // namespace cousin
