#include "sim/sensors/time_of_flight.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <complex>

#include "sim/sensors/range_rig.h"

namespace cousin {
namespace {

constexpr double kLight_m_per_s = 299792458;

TimeOfFlightConfig small_camera() {
  TimeOfFlightConfig config = time_of_flight_preset("kinect_v2");
  config.columns = 96;
  config.rows = 64;
  config.focal_px = 80;
  config.side = 1;
  config.wiggle = 0;
  config.multipath_columns = 0;
  config.depth_unit_m = 1e-4;
  return config;
}

/// A surface of one depth that turns to the camera everywhere.
TimeOfFlightInputs facing(const TimeOfFlightConfig& config, double z_m, float ambient = 0) {
  const int width = config.columns * config.side, height = config.rows * config.side;
  TimeOfFlightInputs in;
  in.depth_m = Image<float>(width, height, static_cast<float>(z_m));
  in.albedo = Image<float>(width, height, 0.5F);
  in.normal = Image<Eigen::Vector3f>(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double f = config.focal_px * config.side;
      in.normal(x, y) =
          -Eigen::Vector3d((x - 0.5 * (width - 1)) / f, (y - 0.5 * (height - 1)) / f, 1)
               .normalized()
               .cast<float>();
    }
  }
  in.ambient = Image<float>(config.columns, config.rows, ambient);
  in.centre_depth_m = Image<float>(config.columns, config.rows, static_cast<float>(z_m));
  return in;
}

TimeOfFlightDepth sense(const TimeOfFlightInputs& in, const TimeOfFlightConfig& config,
                        std::uint64_t seed = 1) {
  return sense_time_of_flight(in, time_of_flight_light(in, config), config, Rng(seed));
}

TEST(TimeOfFlight, WithoutNoiseTheDepthIsTrueUpToTheLargest) {
  TimeOfFlightConfig config = small_camera();
  config.read_noise_e = 0;
  config.signal_e_at_1m = 1e9;  // photon noise of 1e-4 of a radian: 0.02 mm
  config.full_well_e = 1e9;
  config.depth_unit_m = 1e-3;
  config.least_depth_m = 1.2;
  config.largest_depth_m = 15;
  for (const double z : {1.5, 2.7, 6.3, 12.4}) {
    const TimeOfFlightDepth depth = sense(facing(config, z), config);
    for (const auto& [x, y] : {std::pair{48, 32}, {3, 3}, {90, 60}})
      EXPECT_NEAR(depth.depth(x, y) * config.depth_unit_m, z, 2e-3) << z;
  }
  EXPECT_NEAR(unambiguous_range_m(config), 18.737, 1e-3);  // c / 2 over 8 MHz
}

TEST(TimeOfFlight, NoiseIsThatOfThePropagatedPhotons) {
  const TimeOfFlightConfig config = small_camera();
  for (const auto& [z, ambient] : {std::pair{1.0, 0.0F}, {3.0, 0.0F}, {1.5, 0.2F}}) {
    const TimeOfFlightInputs in = facing(config, z, ambient);
    const TimeOfFlightLight light = time_of_flight_light(in, config);
    const TimeOfFlightDepth a = sense_time_of_flight(in, light, config, Rng(1));
    const TimeOfFlightDepth b = sense_time_of_flight(in, light, config, Rng(2));
    double n = 0, squares = 0, expected = 0;
    for (int y = 0; y < config.rows; ++y) {
      for (int x = 0; x < config.columns; ++x) {
        if (a.depth(x, y) == 0 || b.depth(x, y) == 0) continue;
        n += 1;
        squares += 0.5 * std::pow(double(a.range_m(x, y) - b.range_m(x, y)), 2);
        expected += std::pow(time_of_flight_sigma_m(config, double(light.mean_e(x, y)),
                                                    double(light.modulation[2](x, y).norm())),
                             2);
      }
    }
    ASSERT_GT(n, 5000);
    // 6144 differences: 0.9 % of a sigma; first-order propagation is good to a per cent here.
    EXPECT_NEAR(std::sqrt(squares / expected), 1, 0.045) << z;
  }
}

TEST(TimeOfFlight, TheLawOfOneFrequencyIsTheTextbooks) {
  TimeOfFlightConfig config = small_camera();
  config.modulation_hz = {20e6};
  config.read_noise_e = 0;
  // c / (4 pi f) sqrt(B / 2) / A with B = 1000 and A = 400 electrons of a sample.
  EXPECT_NEAR(time_of_flight_sigma_m(config, 1000, 400),
              kLight_m_per_s / (4 * M_PI * 20e6) * std::sqrt(500.0) / 400, 1e-12);
}

TEST(TimeOfFlight, AThirdHarmonicWigglesFourTimesAPeriod) {
  TimeOfFlightConfig config = small_camera();
  config.modulation_hz = {50e6};  // repeats after 3 m
  config.wiggle = 0.05;
  config.read_noise_e = 0;
  config.signal_e_at_1m = 1e8;
  config.full_well_e = 1e9;
  config.least_depth_m = 0.1;
  const double wave_m = kLight_m_per_s / 50e6 / 2;
  for (const double z : {0.8, 1.0, 1.2, 1.4, 1.7}) {
    const TimeOfFlightInputs in = facing(config, z);
    const TimeOfFlightDepth depth = sense(in, config);
    const double range_m = z * Eigen::Vector3d(0.5 / 80, 0.5 / 80, 1).norm();
    const double phase = 2 * M_PI * range_m / wave_m;
    // Four samples fold the third harmonic onto the first, conjugate.
    const std::complex<double> i(0, 1);
    const double error = std::arg(std::exp(i * phase) + 0.05 * std::exp(-3.0 * i * phase)) - phase;
    const double error_m = std::remainder(error, 2 * M_PI) * wave_m / (2 * M_PI);
    EXPECT_NEAR(double(depth.range_m(48, 32)) - range_m, error_m, 5e-4) << z;
  }
}

TEST(TimeOfFlight, PixelsOnAnEdgeFlyWhereTheirLightAddsUpTo) {
  TimeOfFlightConfig config = small_camera();
  config.side = 2;
  config.modulation_hz = {16e6};
  config.signal_e_at_1m = 1e8;
  config.full_well_e = 1e9;
  config.read_noise_e = 0;
  TimeOfFlightInputs in = facing(config, 1.0);
  for (int y = 0; y < in.depth_m.height(); ++y) {
    for (int x = 97; x < in.depth_m.width(); ++x) in.depth_m(x, y) = 2.0F;  // halves pixel 48
  }
  const TimeOfFlightDepth depth = sense(in, config);
  const double wave_m = kLight_m_per_s / 16e6 / 2;
  const std::complex<double> i(0, 1);
  const auto light = [&](double z) { return std::exp(i * (2 * M_PI * z / wave_m)) / (z * z); };
  const double mixed_m = std::arg(light(1) + light(2)) * wave_m / (2 * M_PI);
  EXPECT_NEAR(double(depth.range_m(48, 32)), mixed_m, 2e-3);  // rays are 1e-4 longer than the axis
  EXPECT_GT(mixed_m, 1.05);
  EXPECT_NEAR(double(depth.range_m(46, 32)), 1.0, 1e-3);
  EXPECT_NEAR(double(depth.range_m(51, 32)), 2.0, 2e-3);
}

TEST(TimeOfFlight, InsideASphereTheBounceIsItsChordsLonger) {
  // The camera in the middle of a sphere of radius 1: each patch sends albedo / (4 pi R^2) of its
  // light everywhere, over a chord of 2 R sin(angle / 2).
  TimeOfFlightConfig config = small_camera();
  config.multipath_columns = 32;
  config.modulation_hz = {40e6};
  TimeOfFlightInputs in = facing(config, 1);
  for (int y = 0; y < config.rows; ++y) {
    for (int x = 0; x < config.columns; ++x) in.depth_m(x, y) = -in.normal(x, y).z();  // range 1
  }
  const TimeOfFlightLight light = time_of_flight_light(in, config);
  const double k = 2 * M_PI * 40e6 / kLight_m_per_s;  // a metre of way
  std::complex<double> bounce = 0;
  for (int y = 0; y < config.rows; ++y) {
    for (int x = 0; x < config.columns; ++x) {
      const Eigen::Vector3d d = -in.normal(x, y).cast<double>();
      const double solid_angle = std::pow(d.z(), 3) / (80.0 * 80.0);
      const double chord = (d - Eigen::Vector3d(0.5 / 80, 0.5 / 80, 1).normalized()).norm();
      bounce += 0.5 / (4 * M_PI) * solid_angle * std::exp(std::complex<double>(0, k * (2 + chord)));
    }
  }
  const std::complex<double> all = std::exp(std::complex<double>(0, 2 * k)) + bounce;
  const Eigen::Vector2f& found = light.modulation[0](48, 32);
  const double unit = config.signal_e_at_1m * config.contrast * 0.5;
  // 672 patches as disks: their form factors leave a few per cent of the bounce.
  EXPECT_NEAR(double(found.x()) / unit, all.real(), 0.05 * std::abs(bounce));
  EXPECT_NEAR(double(found.y()) / unit, all.imag(), 0.05 * std::abs(bounce));
  EXPECT_GT(std::abs(bounce), 0.03);
}

TEST(TimeOfFlight, SaysWhyThereIsNoDepth) {
  TimeOfFlightConfig config = small_camera();
  TimeOfFlightInputs in = facing(config, 1.5);
  in.albedo(10, 10) = 0.001F;
  in.depth_m(20, 10) = in.centre_depth_m(20, 10) = std::numeric_limits<float>::quiet_NaN();
  in.ambient(30, 10) = 10;
  const TimeOfFlightDepth depth = sense(in, config);
  EXPECT_EQ(depth.reason(10, 10), InvalidReason::low_signal);
  EXPECT_EQ(depth.reason(20, 10), InvalidReason::out_of_range);
  EXPECT_EQ(depth.reason(30, 10), InvalidReason::saturated);
  EXPECT_EQ(depth.reason(48, 32), InvalidReason::none);
  EXPECT_EQ(sense(facing(config, 4.8), config).reason(48, 32), InvalidReason::out_of_range);
}

TEST(TimeOfFlight, GivesTheSameBytesForAnyNumberOfThreads) {
  TimeOfFlightConfig config = small_camera();
  config.multipath_columns = 6;
  const auto with_threads = [&](std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    return sense(facing(config, 2), config).depth;
  };
  const Image<std::uint16_t> one = with_threads(1);
  EXPECT_EQ(one, with_threads(2));
  EXPECT_EQ(one, with_threads(7));
}

TEST(TimeOfFlight, RejectsWhatDoesNotFit) {
  TimeOfFlightConfig config = small_camera();
  TimeOfFlightInputs in = facing(config, 1);
  in.albedo = Image<float>(3, 3);
  EXPECT_THROW(time_of_flight_light(in, config), std::invalid_argument);
  config.modulation_hz = {16e6, 16e6};
  EXPECT_THROW(validate(config), std::invalid_argument);
  config.modulation_hz = {16.5e6};
  EXPECT_THROW(validate(config), std::invalid_argument);
  config.modulation_hz = {};
  EXPECT_THROW(validate(config), std::invalid_argument);
  EXPECT_THROW(time_of_flight_preset("kinect_v9"), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
