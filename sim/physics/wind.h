#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/config/fields.h"
#include "sim/types/rng.h"

namespace cousin {

/// A wind with gusts: frozen turbulence carried along by the mean wind [Taylor 1938].
struct WindConfig {
  double mean_speed_m_s = 0;     ///< 0: still air; above 30 m/s (a storm) it is refused
  double azimuth_rad = 0;        ///< blows towards, from +x to +y; level
  double intensity = 0.35;       ///< standard deviation along the wind over its mean
  double integral_length_m = 1;  ///< of the gusts along the wind
  double coherence = 10;         ///< decay across the wind, exp(-C f distance / U) [Davenport 1961]
  int modes = 48;                ///< waves a component
  double highest_hz = 20;        ///< faster gusts are left out
};
Fields fields(WindConfig& config);
/// @throws std::invalid_argument naming key, value and limits.
void validate(const WindConfig& config);

/// A sum of waves whose variances follow von Karman's spectrum,
/// f S_u / sigma_u^2 = 4 n / (1 + 70.8 n^2)^(5/6) with n = f L_u / U along the wind, and
/// f S_v / sigma_v^2 = 4 n (1 + 755 n^2) / (1 + 283 n^2)^(11/6) with L_v = L_u / 2 across it
/// [von Karman 1948; ESDU 85020]; sigma_v, sigma_w = 0.80, 0.52 sigma_u [Panofsky & Dutton 1984].
struct WindField {
  struct Mode {
    Eigen::Vector3d amplitude_m_s;
    double angular_rad_s = 0;
    Eigen::Vector3d wave_rad_m;
    double phase_rad = 0;
  };
  Eigen::Vector3d mean_m_s = Eigen::Vector3d::Zero();
  std::vector<Mode> modes;
};
/// @param rng  phases and directions across the wind.
WindField make_wind(const WindConfig& config, Rng rng);
Eigen::Vector3d wind_m_s(const WindField& wind, const Eigen::Vector3d& at_m, double time_s);

/// von Karman's spectra over sigma^2, in s; two-sided use is the caller's matter: these integrate
/// to 1 over f from 0.
double spectrum_along_s(double frequency_hz, double length_m, double speed_m_s);
double spectrum_across_s(double frequency_hz, double length_m, double speed_m_s);

}  // namespace cousin
