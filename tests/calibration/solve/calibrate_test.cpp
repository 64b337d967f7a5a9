#include "calibration/solve/calibrate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "benchmarks/suites/calibration/corner_views.h"
#include "calibration/solve/calibration_uncertainty.h"

namespace cousin {
namespace {

bool built(CalibrationSolver solver) {
#ifdef COUSIN_NO_CERES
  if (solver == CalibrationSolver::ceres) return false;
#endif
#ifdef COUSIN_NO_MRCAL
  if (solver == CalibrationSolver::mrcal) return false;
#endif
  (void)solver;
  return true;
}

CornerViewsConfig close_views() {
  CornerViewsConfig config;
  config.near_m = 0.2;
  config.far_m = 0.45;
  return config;
}

CornerViews views_of(LensModel model, const CornerViewsConfig& config, std::uint64_t seed = 1) {
  return make_corner_views({study_camera(model)}, {Pose{}}, config, Rng(seed));
}

CalibrationConfig tight(CalibrationSolver solver) {
  CalibrationConfig config;
  config.solver = solver;
  config.max_iterations = 300;
  return config;
}

class Parametric : public testing::TestWithParam<LensModel> {};

TEST_P(Parametric, NoiseFreeCornersGiveTheTrueProjection) {
  if (!built(CalibrationSolver::ceres)) GTEST_SKIP() << "built without Ceres";
  CornerViewsConfig config = close_views();
  config.noise_px = 0;
  const CornerViews views = views_of(GetParam(), config);
  const CalibrationResult result = calibrate(views.input, tight(CalibrationSolver::ceres));
  ASSERT_EQ(result.status, CalibrationStatus::ok) << result.reason;
  EXPECT_LT(result.rms_px, 1e-8);
  // 1e-6 px is asked for; corners reach the border.
  EXPECT_LT(projection_difference(views.cameras[0], result.cameras[0]).max_px, 1e-6);
}
INSTANTIATE_TEST_SUITE_P(Models, Parametric,
                         testing::Values(LensModel::pinhole, LensModel::opencv5, LensModel::opencv8,
                                         LensModel::opencv12, LensModel::kannala_brandt4),
                         [](const auto& tested) { return std::string(to_string(tested.param)); });

struct Pairing {
  LensModel model;
  CalibrationSolver other;
  bool without_k3;  ///< OPENCV4
};

class SameCorners : public testing::TestWithParam<Pairing> {};

TEST_P(SameCorners, GiveTheSameMinimumAsTheOtherSolver) {
  const auto [model, other, without_k3] = GetParam();
  if (!built(CalibrationSolver::ceres) || !built(other)) GTEST_SKIP() << "a solver is not built in";
  const CornerViews views = views_of(model, close_views());
  CalibrationConfig ours = tight(CalibrationSolver::ceres), theirs = tight(other);
  if (without_k3) ours.fixed = theirs.fixed = {"k3"};
  const CalibrationResult a = calibrate(views.input, ours), b = calibrate(views.input, theirs);
  ASSERT_FALSE(a.covariance.size() == 0) << a.reason;
  ASSERT_FALSE(b.covariance.size() == 0) << b.reason;
  // Both costs are our sum of squares at the solution found.
  EXPECT_NEAR(a.cost_px2, b.cost_px2, 1e-6 * a.cost_px2);
  ASSERT_EQ(a.parameters, b.parameters);
  for (std::size_t i = 0; i < a.parameters.size(); ++i) {
    EXPECT_NEAR(a.values(static_cast<Eigen::Index>(i)), b.values(static_cast<Eigen::Index>(i)),
                1e-3 * deviation(a, a.parameters[i]))
        << a.parameters[i];
  }
}
INSTANTIATE_TEST_SUITE_P(
    Solvers, SameCorners,
    testing::Values(Pairing{LensModel::opencv5, CalibrationSolver::opencv, true},
                    Pairing{LensModel::opencv5, CalibrationSolver::opencv, false},
                    Pairing{LensModel::opencv8, CalibrationSolver::opencv, false},
                    Pairing{LensModel::opencv12, CalibrationSolver::opencv, false},
                    Pairing{LensModel::kannala_brandt4, CalibrationSolver::opencv, false},
                    Pairing{LensModel::opencv5, CalibrationSolver::mrcal, true},
                    Pairing{LensModel::opencv5, CalibrationSolver::mrcal, false},
                    Pairing{LensModel::opencv8, CalibrationSolver::mrcal, false},
                    Pairing{LensModel::opencv12, CalibrationSolver::mrcal, false}),
    [](const auto& tested) {
      return std::string(to_string(tested.param.model)) +
             (tested.param.without_k3 ? "_no_k3" : "") + "_" +
             std::string(to_string(tested.param.other));
    });

TEST(Calibrate, RmsIsPerCoordinateAndOpenCvIsRootTwoAbove) {
  const CornerViews views = views_of(LensModel::opencv5, close_views());
  const CalibrationResult result = calibrate(views.input, tight(CalibrationSolver::opencv));
  ASSERT_EQ(result.status, CalibrationStatus::ok) << result.reason;
  EXPECT_NEAR(result.solver_rms_px / result.rms_px, std::sqrt(2.0), 1e-6);
  // 2400 coordinates less 189 parameters of noise 0.1 px: the relative error of sigma is 1.5 %.
  EXPECT_NEAR(result.sigma_px, 0.1, 4 * 0.0015);
}

TEST(Calibrate, OpenCvsDeviationsAreTooLargeAndOursAreTheirsCorrected) {
  const CornerViews views = views_of(LensModel::opencv5, close_views());
  const CalibrationResult result = calibrate(views.input, tight(CalibrationSolver::opencv));
  ASSERT_EQ(result.status, CalibrationStatus::ok) << result.reason;
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    const double ours = deviation(result, result.parameters[i]);
    EXPECT_NEAR(result.corrected_deviations(at), ours, 1e-3 * ours) << result.parameters[i];
    EXPECT_GT(result.solver_deviations(at), 1.3 * ours);
  }
}

TEST(Calibrate, MillimetresAndAFarOriginChangeNothing) {
  if (!built(CalibrationSolver::ceres)) GTEST_SKIP() << "built without Ceres";
  const CornerViews views = views_of(LensModel::opencv5, close_views());
  CornerViews other = views;
  const Eigen::Vector3d origin(1e6, -1e6, 1e6);
  for (Eigen::Vector3d& p : other.input.target_m) p = 1000 * p + origin;
  const CalibrationResult a = calibrate(views.input), b = calibrate(other.input);
  ASSERT_EQ(a.status, CalibrationStatus::ok) << a.reason;
  ASSERT_EQ(b.status, CalibrationStatus::ok) << b.reason;
  // 1e6 holds a millimetre to 1e-10, a corner's place to 1e-12 of the board, and the lens' worst
  // coefficient amplifies that by some hundreds.
  for (Eigen::Index i = 0; i < a.values.size(); ++i)
    EXPECT_NEAR(a.values(i), b.values(i), 1e-9 * std::max(1.0, std::abs(a.values(i))));
  const Eigen::Vector3d at = b.frames[3].rig_from_target * origin;
  EXPECT_LT((at - 1000 * a.frames[3].rig_from_target.translation_m).norm(), 1e-6);
}

TEST(Calibrate, OneViewOfAPlaneIsNotDetermined) {
  if (!built(CalibrationSolver::ceres)) GTEST_SKIP() << "built without Ceres";
  CornerViewsConfig config = close_views();
  config.frames = 1;
  const CalibrationResult result = calibrate(views_of(LensModel::opencv5, config).input);
  EXPECT_EQ(result.status, CalibrationStatus::not_determined);
  EXPECT_FALSE(result.not_determined.empty());
}

TEST(Calibrate, BoardsHeldNearlyParallelAreNotDetermined) {
  if (!built(CalibrationSolver::ceres)) GTEST_SKIP() << "built without Ceres";
  CornerViewsConfig config;
  config.tilt_rad = 3 * std::numbers::pi / 180;
  const CalibrationResult result = calibrate(views_of(LensModel::opencv5, config).input);
  EXPECT_EQ(result.status, CalibrationStatus::not_determined) << result.rms_px;
  EXPECT_NE(std::find(result.not_determined.begin(), result.not_determined.end(), "camera0.fx_px"),
            result.not_determined.end());
  EXPECT_LT(result.rms_px, 0.11);  // the residuals say nothing of it
}

// With all coefficients freed at once, these corners led to minima of 53 to 779 times the cost.
TEST(Calibrate, RationalLensesReachTheMinimumThatTheTruthLeadsTo) {
  if (!built(CalibrationSolver::ceres)) GTEST_SKIP() << "built without Ceres";
  const std::pair<LensModel, std::uint64_t> cases[] = {
      {LensModel::opencv8, 3}, {LensModel::opencv8, 10}, {LensModel::opencv12, 10}};
  for (const auto& [model, seed] : cases) {
    const CornerViews views = make_corner_views({study_camera(model)}, {Pose{}}, close_views(),
                                                Rng(seed).fork("agreement"));
    CalibrationInput led = views.input;
    led.cameras[0].start = study_camera(model);
    const CalibrationResult from_truth = calibrate(led, tight(CalibrationSolver::ceres));
    for (const CalibrationSolver solver : {CalibrationSolver::ceres, CalibrationSolver::mrcal}) {
      if (!built(solver)) continue;
      const CalibrationResult found = calibrate(views.input, tight(solver));
      EXPECT_EQ(found.status, CalibrationStatus::ok) << found.reason;
      EXPECT_NEAR(found.cost_px2 / from_truth.cost_px2, 1, 1e-6)
          << to_string(solver) << " " << to_string(model) << " " << seed;
    }
  }
}

TEST(Calibrate, BoardDeformationIsFound) {
  for (const CalibrationSolver solver : {CalibrationSolver::ceres, CalibrationSolver::mrcal}) {
    if (!built(solver)) continue;
    CornerViewsConfig views = close_views();
    views.deformation_m = {0.002, -0.001};
    CalibrationConfig config = tight(solver);
    config.board_deformation = true;
    const CalibrationResult result = calibrate(views_of(LensModel::opencv5, views).input, config);
    ASSERT_EQ(result.status, CalibrationStatus::ok) << result.reason;
    EXPECT_NEAR(result.deformation_m.x(), 0.002, 4 * deviation(result, "kx_m"));
    EXPECT_NEAR(result.deformation_m.y(), -0.001, 4 * deviation(result, "ky_m"));
    EXPECT_LT(deviation(result, "kx_m"), 1e-4);
  }
}

TEST(Calibrate, OutliersAreFoundAndOthersKept) {
  if (!built(CalibrationSolver::ceres)) GTEST_SKIP() << "built without Ceres";
  CornerViewsConfig views = close_views();
  views.outlier_share = 0.1;
  views.outlier_px = 15;
  const CornerViews made = views_of(LensModel::opencv5, views);
  CalibrationConfig config;
  config.reject_sigmas = 5;
  const CalibrationResult result = calibrate(made.input, config);
  ASSERT_EQ(result.status, CalibrationStatus::ok) << result.reason;
  int wrong_kept = 0, right_rejected = 0;
  for (const CalibrationResidual& r : result.residuals) {
    const auto& flags = made.outliers[static_cast<std::size_t>(r.view)];
    std::size_t k = 0;
    while (made.input.views[static_cast<std::size_t>(r.view)].points[k].id != r.id) ++k;
    wrong_kept += flags[k] && !r.rejected ? 1 : 0;
    right_rejected += !flags[k] && r.rejected ? 1 : 0;
  }
  // An outlier is uniform over 30 x 30 px; 1 px square about the truth passes for noise.
  EXPECT_LE(wrong_kept, 3);
  EXPECT_LE(right_rejected, 2);
  EXPECT_LT(projection_difference(made.cameras[0], result.cameras[0]).rms_px, 0.3);
}

TEST(Calibrate, OutliersThatWereKeptAreCounted) {
  const CornerViewsConfig views = close_views();
  CornerViews made = views_of(LensModel::opencv5, views);
  CalibrationConfig config;
  config.solver = default_calibration_solver();
  EXPECT_EQ(calibrate(made.input, config).outliers, 0);
  made.input.views[1].points[7].pixel_px += Eigen::Vector2d(12, -9);
  made.input.views[4].points[2].pixel_px += Eigen::Vector2d(-15, 4);
  EXPECT_GE(calibrate(made.input, config).outliers, 2);  // and neighbours that they drag along
  if (!built(CalibrationSolver::ceres)) return;
  config.reject_sigmas = 5;
  const CalibrationResult result = calibrate(made.input, config);
  EXPECT_EQ(result.outliers, 0);
  EXPECT_EQ(result.rejected, 2);
}

TEST(Calibrate, RefusesWhatItCannotUse) {
  const CornerViews views = views_of(LensModel::opencv5, close_views());
  CalibrationInput input = views.input;
  input.views[2].points[0].id = 40;
  CalibrationResult result = calibrate(input);
  EXPECT_EQ(result.status, CalibrationStatus::bad_input);
  EXPECT_EQ(result.reason, "view 2: point 40 is not one of the target's 40");
  CalibrationConfig config;
  config.fixed = {"k9"};
  EXPECT_EQ(calibrate(views.input, config).reason, "fixed: no camera has a parameter \"k9\"");
  config = tight(CalibrationSolver::opencv);
  config.board_deformation = true;
  EXPECT_EQ(calibrate(views.input, config).status, CalibrationStatus::bad_input);
  config = {};
  config.tolerance = -1;
  EXPECT_THROW((void)calibrate(views.input, config), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
