#include "calibration/devices/registration.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <stdexcept>

#include "benchmarks/suites/calibration/corner_views.h"

namespace cousin {
namespace {

/// Colour camera and left imager of a depth camera, as its maker has them and as they are.
struct DepthCameraRig {
  Camera color, depth;
  Pose depth_from_color;
};

DepthCameraRig true_rig() {
  DepthCameraRig rig;
  rig.color = study_camera(LensModel::opencv5);
  rig.depth = study_camera(LensModel::opencv5);
  rig.depth.fx_px = rig.depth.fy_px = 382;
  rig.depth.distortion = {-0.004, 0.003, 1e-4, 2e-4, 0};
  rig.depth_from_color = {Eigen::Quaterniond(Eigen::AngleAxisd(0.004, Eigen::Vector3d::UnitY())),
                          {-0.059, 0.0002, 0.0005}};
  return rig;
}

DepthRegistration registration(const DepthCameraRig& rig) {
  return {rig.depth, rig.color, inverse(rig.depth_from_color)};
}

CalibrationResult fresh_of(const DepthCameraRig& rig, std::uint64_t seed) {
  CornerViewsConfig config;
  config.frames = 20;
  config.near_m = 0.35;
  config.far_m = 0.7;
  config.columns = 10, config.rows = 7;
  const CornerViews views =
      make_corner_views({rig.color, rig.depth}, {Pose{}, rig.depth_from_color}, config, Rng(seed));
  return calibrate(views.input, {.solver = default_calibration_solver()});
}

TEST(Registration, IsTheClosedFormOfTwoParallelPinholes) {
  DepthRegistration r;
  r.depth = r.color = study_camera(LensModel::pinhole);
  r.color_from_depth.translation_m = {0.06, 0, 0};
  const Eigen::Vector2d q = registered_px(r, {100, 200}, 0.8);
  EXPECT_NEAR(q.x(), 100 + r.color.fx_px * 0.06 / 0.8, 1e-9);
  EXPECT_NEAR(q.y(), 200, 1e-9);
}

TEST(Registration, TheTruthDiffersByWhatTheCovarianceSays) {
  // Against the true registration the mean square difference is the fresh one's own error, whose
  // expectation is fresh_rms^2 and whose deviation is said with it.
  double off = 0, said = 0;
  constexpr int kDraws = 12;
  for (std::uint64_t seed = 0; seed < kDraws; ++seed) {
    const CalibrationResult fresh = fresh_of(true_rig(), seed);
    ASSERT_EQ(fresh.status, CalibrationStatus::ok) << fresh.reason;
    const RegistrationDifference d = registration_difference(registration(true_rig()), fresh, 1, 0);
    off += d.rms_px * d.rms_px - d.fresh_rms_px * d.fresh_rms_px;
    said += d.factory_square_sigma_px2 * d.factory_square_sigma_px2;
    EXPECT_NE(d.verdict, RegistrationVerdict::replace);
    EXPECT_LT(d.fresh_rms_px, 0.6);  // 20 views of 70 corners, each of 0.1 px: 0.15 to 0.45
    EXPECT_GE(d.max_px, d.rms_px);
  }
  EXPECT_LT(std::abs(off), 4 * std::sqrt(said));
}

TEST(Registration, AFactoryThatIsOffIsMeasuredAndReplaced) {
  // Two milliradians about the vertical are 0.8 px, half a millimetre of place is 0.3 px at 0.6 m.
  DepthCameraRig factory = true_rig();
  factory.depth_from_color.rotation =
      factory.depth_from_color.rotation *
      Eigen::Quaterniond(Eigen::AngleAxisd(0.002, Eigen::Vector3d::UnitY()));
  factory.depth_from_color.translation_m.x() += 5e-4;
  const CalibrationResult fresh = fresh_of(true_rig(), 3);
  const RegistrationConfig config;
  const RegistrationDifference d =
      registration_difference(registration(factory), fresh, 1, 0, config);
  double squares = 0;
  int count = 0;
  for (const Eigen::Vector2d& px : d.depth_px) {
    const Eigen::Vector2d error = registered_px(registration(factory), px, config.distance_m) -
                                  registered_px(registration(true_rig()), px, config.distance_m);
    if (error.allFinite()) squares += error.squaredNorm(), ++count;
  }
  const double true_square = squares / count;
  EXPECT_GT(std::sqrt(true_square), 0.5);
  EXPECT_NEAR(d.factory_rms_px * d.factory_rms_px, true_square, 4 * d.factory_square_sigma_px2);
  EXPECT_LT(d.factory_square_sigma_px2, 0.5 * true_square);
  EXPECT_EQ(d.verdict, RegistrationVerdict::replace);
}

TEST(Registration, AVagueCalibrationReplacesNothing) {
  DepthCameraRig factory = true_rig();
  factory.depth_from_color.translation_m.x() += 2e-4;  // 0.13 px at 0.6 m
  CalibrationResult fresh = fresh_of(true_rig(), 5);
  fresh.covariance *= 100;
  EXPECT_NE(registration_difference(registration(factory), fresh, 1, 0).verdict,
            RegistrationVerdict::replace);
}

TEST(Registration, WhatIsMissingIsNamed) {
  const CalibrationResult none;
  EXPECT_THROW((void)registration_difference({}, none, 1, 0), std::invalid_argument);
  CalibrationResult fresh = fresh_of(true_rig(), 5);
  DepthRegistration other = registration(true_rig());
  other.depth.width_px = 848;
  EXPECT_THROW((void)registration_difference(other, fresh, 1, 0), std::invalid_argument);
  RegistrationConfig config;
  config.distance_m = 0;
  EXPECT_THROW((void)registration_difference(registration(true_rig()), fresh, 1, 0, config),
               std::invalid_argument);
}

}  // namespace
}  // namespace cousin
