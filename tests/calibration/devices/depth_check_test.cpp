#include "calibration/devices/depth_check.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <stdexcept>

#include "benchmarks/suites/calibration/corner_views.h"

namespace cousin {
namespace {

constexpr double kFocalBaseline_px_m = 380 * 0.095;

/// A depth camera beside a colour camera, boards before both, and what a calibration says of them.
struct Bench {
  CornerViews views;
  CalibrationResult fresh;
};

Bench bench(int frames, std::uint64_t seed, double near_m = 0.4) {
  const Camera color = study_camera(LensModel::opencv5);
  Camera depth = study_camera(LensModel::pinhole);
  const Pose depth_from_color{
      Eigen::Quaterniond(Eigen::AngleAxisd(0.004, Eigen::Vector3d::UnitY())), {0.059, 0, 0}};
  CornerViewsConfig config;
  config.frames = frames;
  config.near_m = near_m;
  config.far_m = 0.9;
  config.columns = 11, config.rows = 8;
  config.pitch_m = 0.045;
  config.noise_px = 0.03;
  config.whole = false;
  Bench result;
  result.views = make_corner_views({color, depth}, {Pose{}, depth_from_color}, config, Rng(seed));
  result.fresh = calibrate(result.views.input, {.solver = default_calibration_solver()});
  return result;
}

/// A stereo camera's depth of each board by the true lens and pose: disparity off by `shift_px`,
/// scaled by `1 + scale`, with noise of which neighbours share half.
std::vector<DepthView> depth_of(const Bench& bench, double shift_px, double scale,
                                std::uint64_t seed) {
  std::vector<DepthView> views;
  const Camera& camera = bench.views.cameras[1];
  const CalibrationTarget target{TargetKind::chessboard, 12, 9, 0.045, 0, ""};
  for (std::size_t f = 0; f < bench.views.rig_from_target.size(); ++f) {
    const Pose pose = bench.views.camera_from_rig[1] * bench.views.rig_from_target[f];
    Rng rng = Rng(seed).fork(f);
    const double shared_px = 0.02 * normal(rng);
    Image<float> depth_m(camera.width_px, camera.height_px, std::nanf(""));
    for (int y = 0; y < camera.height_px; y += 6) {
      for (int x = 0; x < camera.width_px; x += 6) {
        const double z_m = plane_depth_m(camera, pose, {x, y});
        if (!(z_m > 0)) continue;
        const double disparity_px =
            kFocalBaseline_px_m / z_m + shift_px + shared_px + 0.05 * normal(rng);
        depth_m(x, y) = static_cast<float>((1 + scale) * kFocalBaseline_px_m / disparity_px);
      }
    }
    // Samples are taken where the calibration has the board.
    const CalibrationFrame& placed = bench.fresh.frames[f];
    views.push_back(
        {placed.frame,
         depth_on_target(depth_m, bench.fresh.cameras[1],
                         bench.fresh.camera_from_rig[1] * placed.rig_from_target, target, 12)});
  }
  return views;
}

TEST(DepthCheck, ATrueDepthIsOffByNoMoreThanIsSaid) {
#ifdef COUSIN_NO_CERES
  GTEST_SKIP() << "cameras that see different points need Ceres";
#endif
  double squares = 0;
  constexpr int kDraws = 8;
  for (std::uint64_t seed = 0; seed < kDraws; ++seed) {
    const Bench b = bench(16, seed);
    ASSERT_EQ(b.fresh.status, CalibrationStatus::ok) << b.fresh.reason;
    const DepthCheck check = check_depth(depth_of(b, 0, 0, seed), b.fresh, 1);
    EXPECT_EQ(check.views, 16);
    ASSERT_TRUE(std::isfinite(check.rms_m)) << check.reason;
    EXPECT_NE(check.verdict, DepthVerdict::correct) << check.error_m;
    squares += check.rms_m * check.rms_m /
               (check.spread_m * check.spread_m + check.fresh_m * check.fresh_m);
  }
  // Four freedoms of the bias (two of scale and shift at one depth are one) in eight draws.
  EXPECT_LT(squares / kDraws, 2.5);
  EXPECT_GT(squares / kDraws, 0.2);
}

TEST(DepthCheck, ADepthThatIsOffIsMeasuredAndWorthCorrecting) {
#ifdef COUSIN_NO_CERES
  GTEST_SKIP() << "cameras that see different points need Ceres";
#endif
  const Bench b = bench(16, 3);
  const double shift_px = 0.15, scale = 0.004;
  const DepthCheck check = check_depth(depth_of(b, shift_px, scale, 3), b.fresh, 1);
  EXPECT_EQ(check.verdict, DepthVerdict::correct) << check.reason;
  const double truth_m =
      (1 + scale) * kFocalBaseline_px_m / (kFocalBaseline_px_m / 0.6 + shift_px) - 0.6;
  EXPECT_NEAR(check.mean_m, truth_m, 4 * std::hypot(check.spread_m, check.fresh_m));
  EXPECT_LT(std::hypot(check.spread_m, check.fresh_m), 0.0005);
  // Its inverse takes it out.
  const double measured_m = biased_depth_m(check.bias, {100, 100}, 0.7, 640, 480);
  EXPECT_NEAR(corrected_depth_m(check.bias, {100, 100}, measured_m, 640, 480), 0.7, 1e-12);
}

TEST(DepthCheck, WhatBoardsDoNotTellIsLeftOpen) {
#ifdef COUSIN_NO_CERES
  GTEST_SKIP() << "cameras that see different points need Ceres";
#endif
  const Bench b = bench(16, 5);
  std::vector<DepthView> views = depth_of(b, 0, 0, 5);
  DepthCheckConfig far;
  far.distance_m = 3;
  const DepthCheck beyond = check_depth(views, b.fresh, 1, far);
  EXPECT_EQ(beyond.verdict, DepthVerdict::cannot_tell);
  EXPECT_NE(beyond.reason.find("working distance"), std::string::npos) << beyond.reason;
  views.resize(4);
  const DepthCheck few = check_depth(views, b.fresh, 1);
  EXPECT_EQ(few.verdict, DepthVerdict::cannot_tell);
  EXPECT_NE(few.reason.find("4 boards"), std::string::npos) << few.reason;
  EXPECT_THROW((void)check_depth(views, b.fresh, 2), std::invalid_argument);
  CalibrationResult bare = b.fresh;
  bare.covariance.resize(0, 0);
  EXPECT_THROW((void)check_depth(views, bare, 1), std::invalid_argument);
}

TEST(DepthCheck, SamplesLieOnThePrintAndKeepOffItsBorder) {
  const Camera camera = study_camera(LensModel::pinhole);
  const CalibrationTarget target{TargetKind::chessboard, 10, 7, 0.025, 0, ""};
  const Pose pose{Eigen::Quaterniond(Eigen::AngleAxisd(3.14159265, Eigen::Vector3d::UnitX())),
                  {0, 0, 0.5}};
  Image<float> depth_m(camera.width_px, camera.height_px, 0.5F);
  depth_m(320, 240) = std::nanf("");
  const auto samples = depth_on_target(depth_m, camera, pose, target, 10);
  ASSERT_FALSE(samples.empty());
  const double margin_m = 9.9 * 0.5 / camera.fx_px;
  for (const DepthSample& s : samples) {
    EXPECT_FALSE(s.pixel_px == Eigen::Vector2d(320, 240));
    const Eigen::Vector3d at_m =
        0.5 * *unproject(camera, s.pixel_px) / unproject(camera, s.pixel_px)->z();
    EXPECT_LT(std::abs(at_m.x()), 0.125 - margin_m);
    EXPECT_LT(std::abs(at_m.y()), 0.0875 - margin_m);
    EXPECT_NEAR(s.true_m, 0.5, 1e-8);
  }
  EXPECT_THROW((void)depth_on_target(Image<float>(3, 3), camera, pose, target, 10),
               std::invalid_argument);
}

}  // namespace
}  // namespace cousin
