#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "sim/render/clear_sky.h"
#include "sim/render/spectrum.h"

namespace cousin {
namespace {

double luminance(const Eigen::Vector3d& c) {
  return 0.2126 * c.x() + 0.7152 * c.y() + 0.0722 * c.z();
}

ClearSky sky_at(double elevation_rad, double turbidity) {
  ClearSky sky;
  sky.to_sun = {std::cos(elevation_rad), 0, std::sin(elevation_rad)};
  sky.turbidity = turbidity;
  return sky;
}

TEST(ClearSky, DaylightIsAsBrightAsMeasured) {
  // CIE: a high sun on clear days gives 80 to 110 klx on the level, of which the sky 8 to 25.
  const ClearSkyModel noon(sky_at(1.1, 2.5));
  const double level = luminance(noon.horizontal_irradiance());
  const double sun = luminance(noon.sun_irradiance()) * std::sin(1.1);
  EXPECT_GT(level, 75);
  EXPECT_LT(level, 120);
  EXPECT_GT(level - sun, 6);
  EXPECT_LT(level - sun, 30);
}

TEST(ClearSky, ZenithIsBlueAndALowSunRed) {
  const ClearSkyModel day(sky_at(0.8, 2.5));
  const Eigen::Vector3d zenith = day.radiance({0, 0, 1});
  EXPECT_GT(zenith.z(), 1.5 * zenith.x());
  const ClearSkyModel evening(sky_at(0.05, 4));
  EXPECT_GT(evening.sun_irradiance().x(), 3 * evening.sun_irradiance().z());
  EXPECT_LT(luminance(evening.sun_irradiance()), 0.5 * luminance(day.sun_irradiance()));
}

TEST(ClearSky, IsBrighterRoundTheSunAndHazeDimsTheSun) {
  const ClearSkyModel clean(sky_at(0.8, 2)), hazy(sky_at(0.8, 6));
  const Eigen::Vector3d near_sun = Eigen::Vector3d(std::cos(0.9), 0, std::sin(0.9));
  const Eigen::Vector3d across = Eigen::Vector3d(-std::cos(0.9), 0, std::sin(0.9));
  EXPECT_GT(luminance(clean.radiance(near_sun)), 2 * luminance(clean.radiance(across)));
  EXPECT_LT(luminance(hazy.sun_irradiance()), 0.8 * luminance(clean.sun_irradiance()));
}

TEST(ClearSky, ScalesAndSwitchesOff) {
  ClearSky sky = sky_at(0.8, 3);
  const ClearSkyModel one(sky);
  sky.scale = 2;
  sky.has_sun = false;
  const ClearSkyModel two(sky);
  EXPECT_NEAR(two.radiance({0, 0, 1}).y(), 2 * one.radiance({0, 0, 1}).y(), 1e-12);
  EXPECT_EQ(two.sun_irradiance().norm(), 0);
}

TEST(ClearSky, RefusesByName) {
  EXPECT_THROW(ClearSkyModel(sky_at(-0.1, 3)), std::invalid_argument);
  EXPECT_THROW(ClearSkyModel(sky_at(0.5, 1)), std::invalid_argument);
  EXPECT_THROW(ClearSkyModel(sky_at(0.5, std::nan(""))), std::invalid_argument);
}

TEST(Spectrum, ObserverPeaksWhereItShould) {
  // CIE 1931: y peaks at 555 nm with 1, z at 445 nm with 1.78, x at 599 nm with 1.06.
  EXPECT_NEAR(cie_xyz(555e-9).y(), 1.0, 0.02);
  EXPECT_NEAR(cie_xyz(446e-9).z(), 1.78, 0.05);
  EXPECT_NEAR(cie_xyz(599e-9).x(), 1.06, 0.03);
}

TEST(Spectrum, EvenSpectrumIsNearWhiteAndD65IsWhite) {
  // Illuminant E has x = y = 1/3.
  const Eigen::Vector3d e = xyz_of([](double) { return 1.0; });
  EXPECT_NEAR(e.x() / e.sum(), 1.0 / 3, 0.003);
  EXPECT_NEAR(e.y() / e.sum(), 1.0 / 3, 0.003);
  const Eigen::Vector3d white = linear_srgb({0.95047, 1, 1.08883});
  EXPECT_NEAR(white.x(), 1, 2e-3);
  EXPECT_NEAR(white.y(), 1, 2e-3);
  EXPECT_NEAR(white.z(), 1, 2e-3);
}

TEST(Spectrum, GrowLampIsVioletAndStaysInTheGamut) {
  const std::vector<LedPeak> peaks = {{450e-9, 20e-9, 1}, {660e-9, 20e-9, 2}};
  const Rgbf c = led_color(peaks);
  EXPECT_GE(c.r, 0);
  EXPECT_GE(c.g, 0);
  EXPECT_GE(c.b, 0);
  EXPECT_GT(c.b, 3 * c.g);
  EXPECT_GT(c.r, 3 * c.g);
  EXPECT_NEAR(0.2126F * c.r + 0.7152F * c.g + 0.0722F * c.b, 1, 1e-3F);
  const std::vector<LedPeak> green = {{530e-9, 30e-9, 1}};
  EXPECT_GT(led_color(green).g, led_color(green).r);
  EXPECT_THROW(led_color({}), std::invalid_argument);
  const std::vector<LedPeak> bad = {{200e-9, 20e-9, 1}};
  EXPECT_THROW(led_color(bad), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
