#include "calibration/devices/depth_bias.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "benchmarks/suites/calibration/corner_views.h"

namespace cousin {
namespace {

std::vector<DepthSample> walls(const std::vector<double>& distances_m, double noise_m) {
  std::vector<DepthSample> samples;
  Rng rng(3);
  for (const double z : distances_m) {
    for (int y = 0; y < 480; y += 24) {
      for (int x = 0; x < 640; x += 32) {
        const double r2 = (Eigen::Vector2d(x, y) - Eigen::Vector2d(319.5, 239.5)).squaredNorm() /
                          Eigen::Vector2d(319.5, 239.5).squaredNorm();
        samples.push_back(
            {{x, y}, z + 0.003 + 0.01 * z - 0.004 * r2 * z + noise_m * normal(rng), z});
      }
    }
  }
  return samples;
}

TEST(DepthBias, OffsetScaleAndBowlAreFound) {
  const DepthBias bias = fit_depth_bias(walls({0.4, 0.6, 0.9}, 0.001), 640, 480);
  ASSERT_EQ(bias.status, CalibrationStatus::ok) << bias.reason;
  const double truth[] = {0.003, 0.01, -0.004}, found[] = {bias.offset_m, bias.scale, bias.bowl};
  for (int i = 0; i < 3; ++i)
    EXPECT_NEAR(found[i], truth[i], 4 * std::sqrt(bias.covariance(i, i))) << i;
  const double measured = 0.7 + 0.003 + 0.01 * 0.7 - 0.004 * 0.7;
  EXPECT_NEAR(corrected_depth_m(bias, {0, 0}, measured, 640, 480), 0.7, 5e-4);
}

TEST(DepthBias, OneDistanceDoesNotTellOffsetFromScale) {
  const DepthBias bias = fit_depth_bias(walls({0.6}, 0.001), 640, 480);
  EXPECT_EQ(bias.status, CalibrationStatus::not_determined);
  EXPECT_EQ(bias.not_determined, (std::vector<std::string>{"offset_m", "scale"}));
}

constexpr double kFocalBaseline_px_m = 40.3;  ///< of a D457 at 848 x 480: 424 px, 95 mm
constexpr double kRippleSin_px = 0.05, kRippleCos_px = -0.03;

/// Walls as a stereo camera with a ripple measures them. `slope_m`: farther at the right than at
/// the left by that.
std::vector<DepthSample> rippled_walls(const std::vector<double>& distances_m, double slope_m,
                                       double noise_m, Rng rng) {
  std::vector<DepthSample> samples;
  for (const double distance_m : distances_m) {
    for (int y = 0; y < 480; y += 24) {
      for (int x = 0; x < 640; x += 16) {
        const double z = distance_m + slope_m * (x / 640.0 - 0.5);
        const double d = kFocalBaseline_px_m / z, turn = 2 * std::numbers::pi * d;
        const double read_px = d + kRippleSin_px * std::sin(turn) + kRippleCos_px * std::cos(turn);
        const double measured_m =
            kFocalBaseline_px_m / read_px + 0.003 + 0.01 * z + noise_m * normal(rng);
        samples.push_back({{x, y}, measured_m, z});
      }
    }
  }
  return samples;
}

DepthBiasConfig with_ripple() {
  DepthBiasConfig config;
  config.bowl = false;
  config.ripple = true;
  config.focal_baseline_px_m = kFocalBaseline_px_m;
  return config;
}

TEST(DepthBias, RippleIsFoundAsOftenOffAsItsDeviationSays) {
  // Four terms on 40 draws: the mean square of 160 normalised errors has a deviation of 11 %, a
  // little more as the terms hang together; four of them.
  double squares = 0;
  constexpr int kDraws = 40;
  for (std::uint64_t seed = 0; seed < kDraws; ++seed) {
    const DepthBias bias = fit_depth_bias(
        rippled_walls({0.5, 0.7, 0.9, 1.2}, 0.08, 0.001, Rng(seed)), 640, 480, with_ripple());
    ASSERT_EQ(bias.status, CalibrationStatus::ok) << bias.reason;
    const double truth[] = {0.003, 0.01, kRippleSin_px, kRippleCos_px};
    const double found[] = {bias.offset_m, bias.scale, bias.ripple_sin_px, bias.ripple_cos_px};
    for (int i = 0; i < 4; ++i) {
      const double off = (found[i] - truth[i]) / std::sqrt(bias.covariance(i, i));
      EXPECT_LT(std::abs(off), 4.5) << i;
      squares += off * off;
    }
  }
  EXPECT_NEAR(squares / (4 * kDraws), 1, 0.5);
}

TEST(DepthBias, RippleTakenOutLeavesTheDistance) {
  const DepthBias bias =
      fit_depth_bias(rippled_walls({0.5, 0.7, 0.9, 1.2}, 0.08, 0, Rng(1)), 640, 480, with_ripple());
  ASSERT_EQ(bias.status, CalibrationStatus::ok) << bias.reason;
  const DepthRipple ripple = ripple_of(bias);
  // First order: 1 / (d + e) = 1 / d - e / d^2 + ..., e / d being 0.06 / 34 at 1.2 m.
  EXPECT_NEAR(ripple.amplitude_px, std::hypot(kRippleSin_px, kRippleCos_px), 3e-4);
  EXPECT_NEAR(ripple.phase_rad, std::atan2(kRippleCos_px, kRippleSin_px), 5e-3);
  for (double z = 0.45; z < 1.25; z += 0.0137) {
    const double d = kFocalBaseline_px_m / z, turn = 2 * std::numbers::pi * d;
    const double read_px = d + kRippleSin_px * std::sin(turn) + kRippleCos_px * std::cos(turn);
    const double measured_m = kFocalBaseline_px_m / read_px + 0.003 + 0.01 * z;
    // What the first order leaves: z (e / d)^2 = 4e-6 m; the ripple itself is up to 2 mm.
    EXPECT_NEAR(corrected_depth_m(bias, {100, 100}, measured_m, 640, 480), z, 2e-5);
  }
}

TEST(DepthBias, RippleIsNotDeterminedWhereDisparitiesDoNotSampleThePixel) {
  // Walls face on, each at a whole number of pixels or a fifth beside it.
  std::vector<double> distances_m;
  for (const double d : {80.0, 70.1, 60.2, 50.0, 40.15})
    distances_m.push_back(kFocalBaseline_px_m / d);
  DepthBias bias =
      fit_depth_bias(rippled_walls(distances_m, 0, 0.001, Rng(1)), 640, 480, with_ripple());
  EXPECT_EQ(bias.status, CalibrationStatus::not_determined);
  EXPECT_EQ(bias.not_determined, (std::vector<std::string>{"ripple_sin_px", "ripple_cos_px"}));
  EXPECT_NE(bias.reason.find("period"), std::string::npos) << bias.reason;
  // And without f B there is nothing to take a fraction of.
  DepthBiasConfig config = with_ripple();
  config.focal_baseline_px_m = 0;
  EXPECT_THROW((void)fit_depth_bias({}, 640, 480, config), std::invalid_argument);
}

TEST(DepthBias, PlaneDepthIsAlongTheAxis) {
  const Camera camera = study_camera(LensModel::opencv5);
  const Pose pose{Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX())),
                  {0, 0, 0.5}};
  const Eigen::Vector3d point = pose * Eigen::Vector3d(0.05, -0.08, 0);
  EXPECT_NEAR(plane_depth_m(camera, pose, *project(camera, point)), point.z(), 1e-9);
}

}  // namespace
}  // namespace cousin
