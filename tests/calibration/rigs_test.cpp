#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "benchmarks/calibration/corner_views.h"
#include "benchmarks/calibration/hand_eye_views.h"
#include "calibration/calibrate.h"
#include "calibration/depth_bias.h"
#include "calibration/hand_eye.h"

namespace cousin {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

TEST(HandEye, TwentyStopsFindTheCameraOnTheArm) {
  // Five arms: the limits hold for each.
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const HandEyeViews views = make_hand_eye_views({}, Rng(seed));
    const HandEyeResult result = calibrate_hand_eye(views.input);
    ASSERT_EQ(result.status, CalibrationStatus::ok) << result.reason;
    const HandEyeError error = hand_eye_error(views, result);
    EXPECT_LT(error.place_m, 3e-4);
    EXPECT_LT(error.turn_rad, 0.03 * kDegree);
    // Three coordinates at 4 deviations.
    const double sigma = std::sqrt(result.covariance.diagonal().tail<3>().maxCoeff());
    EXPECT_LT(error.place_m, 4 * std::sqrt(3.0) * sigma);
    EXPECT_GT(sigma, 1e-5);
  }
}

TEST(HandEye, WithoutNoiseIsExact) {
  HandEyeViewsConfig config;
  config.corner_px = config.arm_m = config.arm_rad = 0;
  const HandEyeViews views = make_hand_eye_views(config, Rng(1));
  const HandEyeError error = hand_eye_error(views, calibrate_hand_eye(views.input));
  EXPECT_LT(error.place_m, 1e-8);
  EXPECT_LT(error.turn_rad, 1e-8);
}

TEST(HandEye, PureTranslationAndParallelAxesAreRefused) {
  HandEyeViewsConfig config;
  config.motion = ArmMotion::translation;
  HandEyeResult result = calibrate_hand_eye(make_hand_eye_views(config, Rng(1)).input);
  EXPECT_EQ(result.status, CalibrationStatus::not_determined);
  EXPECT_NE(result.reason.find("only translates"), std::string::npos) << result.reason;
  config.motion = ArmMotion::one_axis;
  result = calibrate_hand_eye(make_hand_eye_views(config, Rng(1)).input);
  EXPECT_EQ(result.status, CalibrationStatus::not_determined);
  EXPECT_NE(result.reason.find("axis of all turns"), std::string::npos) << result.reason;
}

TEST(Rig, TwoCamerasFindTheirBaseline) {
#ifdef COUSIN_NO_CERES
  GTEST_SKIP() << "built without Ceres";
#endif
  const Camera camera = study_camera(LensModel::opencv5);
  const Pose right{Eigen::Quaterniond(Eigen::AngleAxisd(0.006, Eigen::Vector3d::UnitY())),
                   {-0.12, 0.0003, 0.0002}};
  CornerViewsConfig config;
  config.near_m = 0.3;
  config.far_m = 0.6;
  const CornerViews views = make_corner_views({camera, camera}, {Pose{}, right}, config, Rng(8));
  const CalibrationResult result = calibrate(views.input);
  ASSERT_EQ(result.status, CalibrationStatus::ok) << result.reason;
  for (const char axis : {'x', 'y', 'z'}) {
    const double sigma = deviation(result, std::string("camera1.t_") + axis);
    const int k = axis - 'x';
    EXPECT_NEAR(result.camera_from_rig[1].translation_m(k), right.translation_m(k), 4 * sigma);
    EXPECT_LT(sigma, 5e-4);
  }
}

TEST(Rig, HalfTurnsThatAreUnknownAreMadeToAgree) {
#ifdef COUSIN_NO_CERES
  GTEST_SKIP() << "built without Ceres";
#endif
  const Camera camera = study_camera(LensModel::opencv5);
  const Pose right{Eigen::Quaterniond::Identity(), {-0.1, 0, 0}};
  CornerViewsConfig config;
  config.near_m = 0.35;
  const CornerViews views = make_corner_views({camera, camera}, {Pose{}, right}, config, Rng(8));
  CalibrationInput turned = views.input;
  int count = 0;
  for (TargetView& view : turned.views) {
    view.status = TargetStatus::half_turn_unknown;
    if (view.camera != 1 || ++count % 3 != 0) continue;
    for (TargetObservation& p : view.points) p.id = 39 - p.id;
    std::reverse(view.points.begin(), view.points.end());
  }
  const CalibrationResult a = calibrate(views.input), b = calibrate(turned);
  ASSERT_EQ(b.status, CalibrationStatus::ok) << b.reason;
  EXPECT_NEAR(a.cost_px2, b.cost_px2, 1e-6 * a.cost_px2);
}

TEST(Rig, CamerasThatShareNoFrameAreNotDetermined) {
#ifdef COUSIN_NO_CERES
  GTEST_SKIP() << "built without Ceres";
#endif
  const Camera camera = study_camera(LensModel::opencv5);
  CornerViews views = make_corner_views({camera, camera}, {Pose{}, Pose{}}, {}, Rng(8));
  for (TargetView& view : views.input.views) view.frame += 1000 * view.camera;
  const CalibrationResult result = calibrate(views.input);
  EXPECT_EQ(result.status, CalibrationStatus::not_determined);
  EXPECT_EQ(result.not_determined, std::vector<std::string>{"camera1.pose"});
}

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

TEST(DepthBias, PlaneDepthIsAlongTheAxis) {
  const Camera camera = study_camera(LensModel::opencv5);
  const Pose pose{Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX())),
                  {0, 0, 0.5}};
  const Eigen::Vector3d point = pose * Eigen::Vector3d(0.05, -0.08, 0);
  EXPECT_NEAR(plane_depth_m(camera, pose, *project(camera, point)), point.z(), 1e-9);
}

}  // namespace
}  // namespace cousin
