#include "calibration/solve/next_view.h"

#include <gtest/gtest.h>

#include "benchmarks/suites/calibration/corner_views.h"
#include "calibration/solve/calibrate.h"

namespace cousin {
namespace {

TEST(NextView, OfASplinedLensGoesWhereNothingWasSeenAndKeepsItsPromise) {
#ifdef COUSIN_NO_CERES
  GTEST_SKIP() << "built without Ceres";
#endif
  Camera camera = study_camera(LensModel::splined_stereographic);
  CornerViewsConfig config;
  config.frames = 12;
  config.near_m = 0.15;
  config.far_m = 0.3;
  config.tilt_rad = 0.4;
  config.region = {0.1, 0.1, 0.55, 0.9};  // the right of the picture stays empty
  const CornerViews views = make_corner_views({camera}, {Pose{}}, config, Rng(4));
  CalibrationConfig regular;
  regular.spline_prior = 0.1;
  regular.max_deviation_share = 1e6;
  CalibrationInput input = views.input;
  const CalibrationResult before = calibrate(input, regular);
  ASSERT_EQ(before.status, CalibrationStatus::ok) << before.reason;
  const auto next = best_next_view(before, 0, input.target_m);
  ASSERT_TRUE(next);
  EXPECT_LT(next->then_px, next->now_px);
  EXPECT_NE(next->words.find("right"), std::string::npos) << next->words;

  // Taken, with corners of the same noise.
  const Lens lens(camera);
  TargetView view{99, 0, TargetStatus::ok, "", {}};
  Rng noise(5);
  for (std::size_t i = 0; i < input.target_m.size(); ++i) {
    const auto q = lens.project(next->camera_from_target * input.target_m[i]);
    if (!q) continue;
    view.points.push_back(
        {static_cast<int>(i), *q + 0.1 * Eigen::Vector2d(normal(noise), normal(noise))});
  }
  input.views.push_back(view);
  const CalibrationResult after = calibrate(input, regular);
  ASSERT_EQ(after.status, CalibrationStatus::ok) << after.reason;
  const auto further = best_next_view(after, 0, input.target_m);
  ASSERT_TRUE(further);
  // To first order, about another solution.
  EXPECT_NEAR(further->now_px, next->then_px, 0.2 * next->then_px);
}

}  // namespace
}  // namespace cousin
