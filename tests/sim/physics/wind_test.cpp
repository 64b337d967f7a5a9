#include "sim/physics/wind.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <stdexcept>

namespace cousin {
namespace {

TEST(Wind, VonKarmansSpectraHoldTheWholeVariance) {
  for (auto* spectrum : {spectrum_along_s, spectrum_across_s}) {
    // Midpoints in the logarithm, 1e-5 .. 1e5 of the gusts' own frequency.
    double sum = 0;
    const double ratio = std::pow(10.0, 0.01);
    for (double f = 1e-5; f < 1e5; f *= ratio) sum += f * (ratio - 1) * spectrum(f, 1, 1);
    EXPECT_NEAR(sum, 1, 0.02);  // the step of 2.3 % counts each bin by its lower edge
  }
}

TEST(Wind, GustsHaveTheStatedSpreadAndFallWithFrequency) {
  WindConfig config;
  config.mean_speed_m_s = 4;
  config.azimuth_rad = 0.5;
  config.modes = 200;
  config.highest_hz = 200;
  double along = 0, across = 0, up = 0, quick = 0;
  int count = 0;
  const Eigen::Vector3d direction(std::cos(0.5), std::sin(0.5), 0);
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const WindField wind = make_wind(config, Rng(seed));
    for (int i = 0; i < 200; ++i) {
      const Eigen::Vector3d at(0.1, 0.2, 0.3);
      const Eigen::Vector3d gust = wind_m_s(wind, at, 0.37 * i) - wind.mean_m_s;
      const Eigen::Vector3d later = wind_m_s(wind, at, 0.37 * i + 0.002) - wind.mean_m_s;
      along += std::pow(gust.dot(direction), 2);
      across += std::pow(gust.dot(direction.cross(Eigen::Vector3d::UnitZ())), 2);
      up += gust.z() * gust.z();
      quick += std::pow((later - gust).dot(direction), 2);
      ++count;
    }
  }
  // 20 fields of some tens of gusts each: about 5 %.
  const double sigma = 0.35 * 4;
  EXPECT_NEAR(std::sqrt(along / count), sigma, 0.05 * sigma);
  EXPECT_NEAR(std::sqrt(across / count), 0.80 * sigma, 0.05 * sigma);
  EXPECT_NEAR(std::sqrt(up / count), 0.52 * sigma, 0.05 * sigma);
  // In 2 ms it hardly changes.
  EXPECT_LT(std::sqrt(quick / count), 0.25 * sigma);
}

TEST(Wind, CoherenceAcrossDecaysAsDavenports) {
  WindConfig config;
  config.mean_speed_m_s = 5;
  config.modes = 1;  // one wave of each component
  config.highest_hz = 5;
  const double f = [&] {
    return make_wind(config, Rng(0)).modes[0].angular_rad_s / (2 * 3.14159265358979);
  }();
  const double distance = 0.15;
  double sum = 0;
  const int seeds = 4000;
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    const WindField wind = make_wind(config, Rng(seed));
    sum += std::cos(wind.modes[0].wave_rad_m.z() * distance);
  }
  // Standard error of a mean of cosines: 0.7 / sqrt(4000) = 0.011; allow three.
  EXPECT_NEAR(sum / seeds, std::exp(-10 * f * distance / 5), 0.034);
}

TEST(Wind, IsCarriedAlongUnchanged) {
  WindConfig config;
  config.mean_speed_m_s = 3;
  const WindField wind = make_wind(config, Rng(3));
  const Eigen::Vector3d here = wind_m_s(wind, {0, 0, 0.2}, 1);
  const Eigen::Vector3d there = wind_m_s(wind, {0.6, 0, 0.2}, 1.2);
  EXPECT_LT((here - there).norm(), 1e-9);
}

TEST(Wind, AStormIsRefused) {
  WindConfig config;
  config.mean_speed_m_s = 40;
  EXPECT_THROW(make_wind(config, Rng(1)), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
