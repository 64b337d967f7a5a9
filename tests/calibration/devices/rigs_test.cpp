#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "benchmarks/suites/calibration/corner_views.h"
#include "benchmarks/suites/calibration/hand_eye_views.h"
#include "calibration/devices/hand_eye.h"
#include "calibration/solve/calibrate.h"

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

/// Three cameras, of which the last sees less of the boards.
CornerViews rig_views(int cameras) {
  const Camera camera = study_camera(LensModel::opencv5);
  const std::vector<Pose> places = {
      Pose{},
      {Eigen::Quaterniond(Eigen::AngleAxisd(0.006, Eigen::Vector3d::UnitY())),
       {-0.12, 0.0003, 0.0002}},
      {Eigen::Quaterniond(Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitX())), {0.05, -0.06, 0.01}}};
  CornerViewsConfig config;
  config.near_m = 0.3;
  config.far_m = 0.6;
  const auto n = static_cast<std::ptrdiff_t>(cameras);
  return make_corner_views(std::vector<Camera>(static_cast<std::size_t>(cameras), camera),
                           {places.begin(), places.begin() + n}, config, Rng(8));
}

/// Frames in which all cameras see all points: what cv::stereoCalibrate takes.
CalibrationInput seen_by_all(const CalibrationInput& input) {
  std::map<int, std::size_t> whole;
  for (const TargetView& view : input.views)
    whole[view.frame] += view.points.size() == input.target_m.size() ? 1U : 0U;
  CalibrationInput some = input;
  std::erase_if(some.views,
                [&](const TargetView& view) { return whole[view.frame] != input.cameras.size(); });
  return some;
}

void expect_same_minimum(const CalibrationResult& a, const CalibrationResult& b) {
  ASSERT_EQ(a.status, CalibrationStatus::ok) << a.reason;
  ASSERT_EQ(b.status, CalibrationStatus::ok) << b.reason;
  ASSERT_EQ(a.observations, b.observations);
  // Both costs are our sum of squares at the solution found.
  EXPECT_NEAR(a.cost_px2, b.cost_px2, 1e-6 * a.cost_px2);
  ASSERT_EQ(a.parameters, b.parameters);
  for (std::size_t i = 0; i < a.parameters.size(); ++i) {
    EXPECT_NEAR(a.values(static_cast<Eigen::Index>(i)), b.values(static_cast<Eigen::Index>(i)),
                1e-3 * deviation(a, a.parameters[i]))
        << a.parameters[i];
  }
}

TEST(Rig, StereoCalibrateFindsTheMinimumOfCeres) {
#ifdef COUSIN_NO_CERES
  GTEST_SKIP() << "built without Ceres";
#endif
  const CalibrationInput input = seen_by_all(rig_views(2).input);
  ASSERT_GE(input.views.size(), 30U);
  CalibrationConfig theirs;
  theirs.solver = CalibrationSolver::opencv;
  theirs.max_iterations = 300;
  expect_same_minimum(calibrate(input), calibrate(input, theirs));
}

TEST(Rig, StereoCalibrateTakesWhatBothSeeAndFindsTheBaseline) {
  const CornerViews views = rig_views(2);
  CalibrationInput input = views.input;
  // Every third view lacks a row, and one camera misses two frames.
  for (std::size_t i = 0; i < input.views.size(); i += 3)
    input.views[i].points.erase(input.views[i].points.begin(), input.views[i].points.begin() + 8);
  std::erase_if(input.views, [](const TargetView& v) { return v.camera == 1 && v.frame < 2; });
  CalibrationConfig config;
  config.solver = CalibrationSolver::opencv;
  const CalibrationResult result = calibrate(input, config);
  ASSERT_EQ(result.status, CalibrationStatus::ok) << result.reason;
  for (const char axis : {'x', 'y', 'z'}) {
    const double sigma = deviation(result, std::string("camera1.t_") + axis);
    const int k = axis - 'x';
    EXPECT_NEAR(result.camera_from_rig[1].translation_m(k),
                views.camera_from_rig[1].translation_m(k), 4 * sigma);
    EXPECT_LT(sigma, 5e-4);
  }
  EXPECT_NEAR(result.solver_rms_px / result.rms_px, std::sqrt(2.0), 1e-5);
}

TEST(Rig, ThreeCamerasAreNotOpenCvs) {
  CalibrationConfig config;
  config.solver = CalibrationSolver::opencv;
  const CalibrationResult result = calibrate(rig_views(3).input, config);
  EXPECT_EQ(result.status, CalibrationStatus::bad_input);
  EXPECT_NE(result.reason.find("not 3"), std::string::npos) << result.reason;
}

TEST(Rig, MrcalFindsTheMinimumOfCeresForThreeCameras) {
#if defined(COUSIN_NO_CERES) || defined(COUSIN_NO_MRCAL)
  GTEST_SKIP() << "a solver is not built in";
#endif
  const CornerViews views = rig_views(3);
  CalibrationConfig theirs;
  theirs.solver = CalibrationSolver::mrcal;
  expect_same_minimum(calibrate(views.input), calibrate(views.input, theirs));
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

}  // namespace
}  // namespace cousin
