#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <vector>

#include "sim/sensors/phone.h"

namespace cousin {
namespace {

/// A phone of 640 x 480 whose lens does nothing, so that a flat field stays flat.
PhoneConfig flat_phone() {
  PhoneConfig config;
  config.lens = LensModel::pinhole;
  config.distortion = {};
  config.width_px = 640;
  config.height_px = 480;
  config.blur_sigma_px = 0;
  config.vignetting_a = config.vignetting_b = config.vignetting_c = 0;
  config.electrons_at_unit_radiance = 1000;
  config.full_well_e = 8000;
  config.bits = 12;
  return config;
}

TrueView still_view(const PhoneUnit& unit) {
  TrueView view;
  view.camera = unit.camera_at_infinity;
  return view;
}

Image<LinearCode> flat_field(const PhoneConfig& config, const PhoneUnit& unit, double electrons,
                             std::uint64_t seed) {
  const auto radiance = static_cast<float>(electrons / config.electrons_at_unit_radiance);
  return expose(Image<Rgbf>(config.width_px, config.height_px, {radiance, radiance, radiance}),
                config, unit, still_view(unit), Rng(seed));
}

std::vector<double> values(const Image<LinearCode>& image) {
  std::vector<double> all;
  for (const LinearCode& code : image)
    all.insert(all.end(), {double(code.r), double(code.g), double(code.b)});
  return all;
}

double mean_of(const std::vector<double>& v) {
  double sum = 0;
  for (const double x : v) sum += x;
  return sum / static_cast<double>(v.size());
}

double variance_of(const std::vector<double>& v) {
  const double mean = mean_of(v);
  double sum = 0;
  for (const double x : v) sum += (x - mean) * (x - mean);
  return sum / static_cast<double>(v.size() - 1);
}

struct TransferPoint {
  double mean = 0;
  double variance = 0;
};

/// Two frames of one flat field: half the variance of their difference holds no fixed pattern.
TransferPoint transfer_point(const PhoneConfig& config, const PhoneUnit& unit, double electrons,
                             std::uint64_t seed) {
  std::vector<double> a = values(flat_field(config, unit, electrons, seed));
  const std::vector<double> b = values(flat_field(config, unit, electrons, seed + 1));
  const double mean = 0.5 * (mean_of(a) + mean_of(b));
  for (std::size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
  return {mean, 0.5 * variance_of(a)};
}

// EMVA 1288 photon transfer: variance = K^2 read^2 + 1/12 + K mean.
TEST(Phone, PhotonTransferGivesTheGainAndTheReadNoise) {
  PhoneConfig config = flat_phone();
  config.width_px = 320;
  config.height_px = 240;
  config.read_noise_e = 10;
  const PhoneUnit unit = make_phone(config, Rng(1));
  const double gain = 4095 / config.full_well_e;

  // Weighted straight line through 50 exposures between 60 e (six sigmas above the clip at zero)
  // and 80 % of full well.
  double sw = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (int i = 0; i < 50; ++i) {
    const double electrons = 60 * std::pow(0.8 * config.full_well_e / 60, i / 49.0);
    const TransferPoint p =
        transfer_point(config, unit, electrons, 100 + 2 * static_cast<std::uint64_t>(i));
    const double w = 1 / (p.variance * p.variance);
    sw += w;
    sx += w * p.mean;
    sy += w * p.variance;
    sxx += w * p.mean * p.mean;
    sxy += w * p.mean * p.variance;
  }
  const double slope = (sw * sxy - sx * sy) / (sw * sxx - sx * sx);
  const double intercept = (sy - slope * sx) / sw;
  const double expected = gain * gain * 100 + 1.0 / 12;
  EXPECT_NEAR(slope, gain, 0.005 * gain);
  EXPECT_NEAR(intercept, expected, 0.02 * expected);
}

TEST(Phone, ShotNoiseIsPoissonOnBothSidesOfTheSwitchToNormal) {
  PhoneConfig config = flat_phone();
  config.read_noise_e = config.prnu = config.dsnu_e = 0;
  config.bits = 16;
  config.full_well_e = 6553.5;  // ten codes an electron: rounding adds nothing
  const PhoneUnit unit = make_phone(config, Rng(1));
  const double codes_per_e = 10;
  for (const double electrons : {0.5, 5.0, 29.9, 30.1, 300.0}) {
    const std::vector<double> codes = values(flat_field(config, unit, electrons, 7));
    const double mean = mean_of(codes) / codes_per_e;
    const double variance = variance_of(codes) / (codes_per_e * codes_per_e);
    double third = 0;
    for (const double c : codes) third += std::pow(c / codes_per_e - mean, 3);
    third /= static_cast<double>(codes.size());
    // 921 600 samples: sigma of the mean is sqrt(mu / n), of the variance mu sqrt((2 + 1/mu) / n);
    // five of them.
    EXPECT_NEAR(mean, electrons, 5 * std::sqrt(electrons / 921600) + 0.001) << electrons;
    EXPECT_NEAR(variance, electrons,
                5 * electrons * std::sqrt((2 + 1 / electrons) / 921600) + 0.002)
        << electrons;
    // Third central moment of a Poisson count is its mean; its sampling sigma is about sqrt(15 mu^3
    // / n).
    EXPECT_NEAR(third, electrons, 6 * std::sqrt((15 * std::pow(electrons, 3) + 25) / 921600))
        << electrons;
  }
}

TEST(Phone, SensorVarianceIsTheMeasuredTemporalVariance) {
  PhoneConfig config = flat_phone();
  config.read_noise_e = 4;
  config.bits = 10;
  const PhoneUnit unit = make_phone(config, Rng(1));
  const double radiance_per_code = config.full_well_e / 1023 / config.electrons_at_unit_radiance;
  for (const double radiance : {0.05, 0.5, 5.0}) {
    const TransferPoint p =
        transfer_point(config, unit, radiance * config.electrons_at_unit_radiance, 500);
    const double measured = p.variance * radiance_per_code * radiance_per_code;
    // Half the variance of 921 600 differences: relative sigma 0.15 %; allow five.
    EXPECT_NEAR(measured / sensor_variance(config, radiance), 1, 0.0075) << radiance;
  }
}

TEST(Phone, SaturatesAtTheLargestCode) {
  PhoneConfig config = flat_phone();
  const PhoneUnit unit = make_phone(config, Rng(1));
  for (const LinearCode& code : flat_field(config, unit, 3 * config.full_well_e, 1)) {
    ASSERT_EQ(code, (LinearCode{4095, 4095, 4095}));
  }
  const SensorFrame frame =
      sense(Image<Rgbf>(640, 480, {100, 100, 100}), config, unit, still_view(unit), Rng(2));
  for (const Rgb8& pixel : frame.color) ASSERT_EQ(pixel, (Rgb8{255, 255, 255}));
}

// EMVA 1288: spatial standard deviation of a temporal mean, less what is left of the temporal
// noise.
TEST(Phone, FixedPatternHasTheConfiguredSpread) {
  PhoneConfig config = flat_phone();
  config.prnu = 0.01;
  config.dsnu_e = 6;
  const PhoneUnit unit = make_phone(config, Rng(3));
  const double e_per_code = config.full_well_e / 4095;
  const auto spatial_sigma_e = [&](double electrons) {
    constexpr int kFrames = 8;
    std::vector<double> mean(3 * 640 * 480);
    for (int frame = 0; frame < kFrames; ++frame) {
      const std::vector<double> one =
          values(flat_field(config, unit, electrons, 40 + static_cast<std::uint64_t>(frame)));
      for (std::size_t i = 0; i < one.size(); ++i) mean[i] += one[i] / kFrames;
    }
    const double temporal = sensor_variance(config, electrons / 1000) * 1e6 / kFrames;
    return std::sqrt(variance_of(mean) * e_per_code * e_per_code - temporal);
  };
  // At 100 e the offsets dominate, at 6000 e the gains; sampling error of each sigma is below 0.3
  // %.
  EXPECT_NEAR(spatial_sigma_e(100), std::hypot(6, 0.01 * 100), 0.06);
  EXPECT_NEAR(spatial_sigma_e(6000), std::hypot(6, 0.01 * 6000), 0.6);
}

TEST(Phone, GivesTheSameBytesOnAnyNumberOfThreads) {
  PhoneConfig config = flat_phone();
  config.blur_sigma_px = 0.7;
  config.vignetting_a = -0.3;
  Image<Rgbf> radiance(640, 480);
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) {
      radiance(x, y) = {0.01F * static_cast<float>(x % 97), 0.002F * static_cast<float>(y), 0.3F};
    }
  }
  const auto run = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const PhoneUnit unit = make_phone(config, Rng(5));
    return sense(radiance, config, unit, still_view(unit), Rng(6)).color;
  };
  const Image<Rgb8> one = run(1);
  EXPECT_EQ(run(2), one);
  EXPECT_EQ(run(7), one);
}

TEST(Phone, TwoPhonesAndTwoFramesDiffer) {
  const PhoneConfig config = flat_phone();
  const PhoneUnit a = make_phone(config, Rng(1));
  const PhoneUnit b = make_phone(config, Rng(2));
  EXPECT_NE(a.prnu_gain, b.prnu_gain);
  EXPECT_NE(flat_field(config, a, 1000, 1), flat_field(config, a, 1000, 2));
}

TEST(Phone, AutomaticExposurePutsTheBrightestAtEightyPercentOfFullWell) {
  PhoneConfig config = flat_phone();
  config.electrons_at_unit_radiance = 0;
  Image<Rgbf> radiance(640, 480, {0.1F, 0.2F, 0.05F});
  for (int x = 0; x < 640; ++x) {
    for (int y = 0; y < 10; ++y) radiance(x, y) = {0.1F, 4.0F, 0.1F};  // 2 % of the image
  }
  EXPECT_NEAR(electrons_per_radiance(config, radiance) * 4.0, 0.8 * config.full_well_e, 1e-3);
  // A black frame has no brightest part; it must still give a finite exposure.
  EXPECT_EQ(electrons_per_radiance(config, Image<Rgbf>(640, 480)), 0.8 * config.full_well_e);
}

TEST(Phone, RejectsRadianceThatIsNotFiniteOrOfAnotherSize) {
  const PhoneConfig config = flat_phone();
  const PhoneUnit unit = make_phone(config, Rng(1));
  Image<Rgbf> radiance(640, 480, {0.5F, 0.5F, 0.5F});
  radiance(3, 17).g = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(sense(radiance, config, unit, still_view(unit), Rng(1)), std::invalid_argument);
  radiance(3, 17).g = std::numeric_limits<float>::infinity();
  EXPECT_THROW(sense(radiance, config, unit, still_view(unit), Rng(1)), std::invalid_argument);
  EXPECT_THROW(sense(Image<Rgbf>(639, 480), config, unit, still_view(unit), Rng(1)),
               std::invalid_argument);
}

}  // namespace
}  // namespace cousin
