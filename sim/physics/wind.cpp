#include "sim/physics/wind.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "sim/config/limits.h"

namespace cousin {

Fields fields(WindConfig& c) {
  return {
      {"mean_speed_m_s", &c.mean_speed_m_s, "mean wind; 0 = still air", 0, 30},
      {"azimuth_rad", &c.azimuth_rad, "blows towards, from +x to +y", -10, 10},
      {"intensity", &c.intensity, "standard deviation along the wind over its mean", 0, 1},
      {"integral_length_m", &c.integral_length_m, "of the gusts along the wind", 0.01, 1000},
      {"coherence", &c.coherence, "decay across the wind: exp(-C f distance / U)", 0, 100},
      {"modes", &c.modes, "waves a component", 1, 4096},
      {"highest_hz", &c.highest_hz, "faster gusts are left out", 0.1, 1000},
  };
}

void validate(const WindConfig& config) {
  WindConfig copy = config;
  check_limits(fields(copy), "wind");
}

double spectrum_along_s(double frequency_hz, double length_m, double speed_m_s) {
  const double n = frequency_hz * length_m / speed_m_s;
  return 4 * length_m / speed_m_s / std::pow(1 + 70.8 * n * n, 5.0 / 6);
}

double spectrum_across_s(double frequency_hz, double length_m, double speed_m_s) {
  const double n = frequency_hz * length_m / speed_m_s;
  return 4 * length_m / speed_m_s * (1 + 755.2 * n * n) / std::pow(1 + 283.2 * n * n, 11.0 / 6);
}

WindField make_wind(const WindConfig& config, Rng rng) {
  validate(config);
  WindField wind;
  const double speed = config.mean_speed_m_s;
  const Eigen::Vector3d along(std::cos(config.azimuth_rad), std::sin(config.azimuth_rad), 0);
  wind.mean_m_s = speed * along;
  if (!(speed > 0 && config.intensity > 0)) return wind;
  const Eigen::Vector3d across(-along.y(), along.x(), 0);
  const std::array<Eigen::Vector3d, 3> directions = {along, across, Eigen::Vector3d::UnitZ()};
  constexpr std::array<double, 3> kRelative = {1, 0.80, 0.52};
  // Bins even in the logarithm from a hundredth of the gusts' own frequency on.
  const double lowest_hz = std::min(0.01 * speed / config.integral_length_m, config.highest_hz / 2);
  const double ratio = std::pow(config.highest_hz / lowest_hz, 1.0 / config.modes);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Rng waves = rng.fork("component").fork(axis);
    for (int i = 0; i < config.modes; ++i) {
      const double low = i == 0 ? 0 : lowest_hz * std::pow(ratio, i);
      const double high = lowest_hz * std::pow(ratio, i + 1);
      const double f = i == 0 ? high / ratio : std::sqrt(low * high);
      // The bin's share of the variance, by Simpson's rule.
      const auto spectrum = [&](double at_hz) {
        return axis == 0 ? spectrum_along_s(at_hz, config.integral_length_m, speed)
                         : spectrum_across_s(at_hz, config.integral_length_m / 2, speed);
      };
      const double variance =
          (high - low) / 6 * (spectrum(low) + 4 * spectrum(0.5 * (low + high)) + spectrum(high));
      const double sigma = kRelative[axis] * config.intensity * speed;
      WindField::Mode mode;
      mode.amplitude_m_s = std::sqrt(2 * variance) * sigma * directions[axis];
      mode.angular_rad_s = 2 * std::numbers::pi * f;
      // Numbers of waves across the wind of Cauchy's law: their mean over waves decays as
      // Davenport's coherence. Far ones are cut.
      const Eigen::Vector2d gauss(normal(waves), normal(waves));
      const double spread = config.coherence * f / speed / std::max(0.02, std::abs(normal(waves)));
      mode.wave_rad_m = -mode.angular_rad_s / speed * along +
                        spread * (gauss.x() * across + gauss.y() * Eigen::Vector3d::UnitZ());
      mode.phase_rad = uniform(waves, 0, 2 * std::numbers::pi);
      wind.modes.push_back(mode);
    }
  }
  return wind;
}

Eigen::Vector3d wind_m_s(const WindField& wind, const Eigen::Vector3d& at_m, double time_s) {
  Eigen::Vector3d sum = wind.mean_m_s;
  for (const WindField::Mode& mode : wind.modes) {
    sum += mode.amplitude_m_s *
           std::cos(mode.angular_rad_s * time_s + mode.wave_rad_m.dot(at_m) + mode.phase_rad);
  }
  return sum;
}

}  // namespace cousin
