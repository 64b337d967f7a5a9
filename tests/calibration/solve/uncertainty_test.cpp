#include <gtest/gtest.h>

#include <cmath>

#include "benchmarks/suites/calibration/corner_views.h"
#include "benchmarks/suites/calibration/coverage.h"
#include "calibration/solve/calibration_uncertainty.h"

namespace cousin {
namespace {

#ifdef COUSIN_NO_CERES
constexpr bool kCeres = false;
#else
constexpr bool kCeres = true;
#endif

CornerViewsConfig close_views() {
  CornerViewsConfig config;
  config.near_m = 0.2;
  config.far_m = 0.45;
  return config;
}

class CoverageOf : public testing::TestWithParam<ProjectionGauge> {};

TEST_P(CoverageOf, PredictedIntervalsHoldTheTruthAsOftenAsTheySay) {
  if (!kCeres) GTEST_SKIP() << "built without Ceres";
  CoverageConfig config;
  config.views = close_views();
  config.views.frames = 12;
  config.gauge = GetParam();
  config.distance_m =
      GetParam() == ProjectionGauge::mean_frames ? 0.35 : std::numeric_limits<double>::infinity();
  config.calibrations = 150;
  const Coverage found = projection_coverage(config, Rng(3));
  ASSERT_EQ(found.failed, 0);
  // 150 calibrations of ten intervals that are correlated, as many as four independent ones:
  // standard errors of 0.9 and 1.9 %; allow three. The bench has 1000.
  EXPECT_NEAR(found.within_95, 0.95, 0.027);
  EXPECT_NEAR(found.within_68, 0.68, 0.057);
}
INSTANTIATE_TEST_SUITE_P(Gauges, CoverageOf,
                         testing::Values(ProjectionGauge::best_fit, ProjectionGauge::mean_frames),
                         [](const auto& tested) {
                           return tested.param == ProjectionGauge::best_fit ? "best_fit"
                                                                            : "mean_frames";
                         });

TEST(Uncertainty, OfMeanFramesIsLeastWhereTheBoardsWere) {
  if (!kCeres) GTEST_SKIP() << "built without Ceres";
  const CornerViews views =
      make_corner_views({study_camera(LensModel::opencv5)}, {Pose{}}, close_views(), Rng(2));
  const CalibrationResult result = calibrate(views.input);
  ASSERT_EQ(result.status, CalibrationStatus::ok) << result.reason;
  UncertaintyConfig config;
  config.gauge = ProjectionGauge::mean_frames;
  const auto at = [&](double distance_m) {
    config.distance_m = distance_m;
    return rms_deviation_px(projection_uncertainty(result, 0, config));
  };
  EXPECT_LT(at(0.33), at(0.1));
  EXPECT_LT(at(0.33), at(3));
  EXPECT_NEAR(at(1e9), at(std::numeric_limits<double>::infinity()), 1e-6);
}

TEST(Uncertainty, HalvesWithFourTimesTheViews) {
  if (!kCeres) GTEST_SKIP() << "built without Ceres";
  double rms[2];
  for (int i = 0; i < 2; ++i) {
    CornerViewsConfig config = close_views();
    config.frames = i == 0 ? 25 : 100;
    const CornerViews views =
        make_corner_views({study_camera(LensModel::opencv5)}, {Pose{}}, config, Rng(2));
    const CalibrationResult result = calibrate(views.input);
    ASSERT_EQ(result.status, CalibrationStatus::ok) << result.reason;
    rms[i] = rms_deviation_px(projection_uncertainty(result, 0));
  }
  // Which poses were drawn changes it by a fifth.
  EXPECT_NEAR(rms[0] / rms[1], 2, 0.4);
}

TEST(ProjectionDifference, FindsTheMotionAndNothingElse) {
  const Camera camera = study_camera(LensModel::opencv5);
  const ProjectionDifference none = projection_difference(camera, camera);
  EXPECT_LT(none.max_px, 1e-9);
  // A turn moves the principal point, but the image's side by 1 + x^2 as much: it is taken out
  // with a smaller turn, and some of it is left.
  Camera shifted = camera;
  shifted.cx_px += 1;
  const ProjectionDifference turn = projection_difference(camera, shifted);
  EXPECT_NEAR(angle_rad(turn.b_from_a.rotation), 1 / camera.fx_px, 0.3 / camera.fx_px);
  EXPECT_LT(turn.rms_px, 0.35);
  // A longer lens cannot be turned away: 1 % is 3 px at the side.
  Camera longer = camera;
  longer.fx_px *= 1.01;
  longer.fy_px *= 1.01;
  EXPECT_NEAR(projection_difference(camera, longer).max_px, 0.01 * 400, 0.6);
  longer.width_px = 100;
  EXPECT_THROW((void)projection_difference(camera, longer), std::invalid_argument);
}

TEST(CrossValidation, AgreesWithItsPredictionForTheRightModelAndNotForALeanOne) {
  if (!kCeres) GTEST_SKIP() << "built without Ceres";
  CornerViewsConfig config = close_views();
  config.frames = 40;
  config.noise_px = 0.03;
  CornerViews views =
      make_corner_views({study_camera(LensModel::opencv5)}, {Pose{}}, config, Rng(4));
  const CrossValidation right = cross_validate(views.input, {});
  ASSERT_EQ(right.status, CalibrationStatus::ok) << right.reason;
  EXPECT_LT(right.difference.rms_px, 2 * right.predicted_rms_px);
  views.input.cameras[0].start.model = LensModel::pinhole;
  const CrossValidation lean = cross_validate(views.input, {});
  EXPECT_GT(lean.difference.rms_px, 3 * right.difference.rms_px);
}

TEST(ValidRegion, EndsWhereTheCornersEnd) {
  if (!kCeres) GTEST_SKIP() << "built without Ceres";
  CornerViewsConfig config = close_views();
  config.region = {0.3, 0.3, 0.4, 0.7};
  config.near_m = 0.35;
  const CornerViews views =
      make_corner_views({study_camera(LensModel::opencv5)}, {Pose{}}, config, Rng(2));
  const CalibrationResult result = calibrate(views.input);
  ASSERT_FALSE(result.cameras.empty()) << result.reason;
  const UncertaintyMap map = projection_uncertainty(result, 0);
  const ValidRegion region = valid_region(result, views.input, 0, map, 1e9);
  EXPECT_TRUE(region.valid[static_cast<std::size_t>(6 * map.columns + 5)]);    // (213, 261)
  EXPECT_FALSE(region.valid[static_cast<std::size_t>(6 * map.columns + 15)]);  // right border
  EXPECT_EQ(valid_region(result, views.input, 0, map, 0).share, 0);
}

}  // namespace
}  // namespace cousin
