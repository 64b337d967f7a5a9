#include "benchmarks/suites/sensors/depth_wall.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/sensors/fast_normal.h"
#include "tests/sim/sensors/depth_test_scenes.h"

namespace cousin {
namespace {

// The fast model adds errors of known size: the scores must find them again.
TEST(DepthWall, ScoresFindTheErrorsThatWerePutIn) {
  ActiveStereoConfig config = test::small_depth_camera();
  config.disparity_step_px = 0;
  config.depth_unit_m = 1e-4;
  DepthModelConfig& m = config.model;
  m.spatial_px = {0.08, 0.08};
  m.temporal_px = {0.05, 0.05};
  m.spatial_wave = m.temporal_wave = m.fill_wave = {0, 0};
  m.contrast = {0, 20};
  m.fill_score = {normal_quantile(0.8), normal_quantile(0.8)};
  m.slope_spatial = m.slope_temporal = m.slope_fill = m.fatten_px = m.rim_px = 0;
  m.ripple_px = {0.04, 0.04};
  m.bias_px = 0.1;
  m.band_px = 2;
  m.grain_px = 5;
  const ActiveStereoUnit unit = make_active_stereo(config, Rng(1));
  const WallView view = see_wall({0.9, 0.5, 0.5, 0.02, 0}, config, unit, Rng(2));
  const WallScores s = score_fast_model(view, config, unit, 6, Rng(3));
  // 160 x 120 pixels of a grain of 25: 770 independent draws, 2.5 % of a spread; 0.004 of a mean,
  // 0.006 of the ripple's amplitude; 0.015 of the fill.
  EXPECT_NEAR(s.fill, 0.8, 4 * 0.015);
  EXPECT_NEAR(s.bias_px, 0.1, 4 * 0.004);
  EXPECT_NEAR(s.ripple_px, 0.04, 4 * 0.006);
  // The ripple is fixed too: its mean square is half the square of its amplitude.
  EXPECT_NEAR(s.spatial_px, std::hypot(0.08, 0.04 / std::sqrt(2.0)), 4 * 0.025 * 0.085);
  EXPECT_NEAR(s.temporal_px, 0.05, 4 * 0.025 * 0.05);
  EXPECT_NEAR(s.sigma_px, std::hypot(s.spatial_px, s.temporal_px), 0.003);
  EXPECT_EQ(s.wrong, 0);
  EXPECT_GT(s.slope, 0.02);
  EXPECT_EQ(s.pixels, 160 * 120);
}

TEST(DepthWall, AWallIsWhereItIsSaidToBe) {
  const ActiveStereoConfig config = test::small_depth_camera();
  const ActiveStereoUnit unit = make_active_stereo(config, Rng(1));
  const WallView view = see_wall({0.9, 0.5, 0.3, 0.1, 0}, config, unit, Rng(2));
  EXPECT_NEAR(view.pair.depth_m(160, 120), 0.9, 0.01);
  // Turned by 0.5 rad about the vertical: the normal's angle to the axis.
  EXPECT_NEAR(std::acos(-view.inputs.normal(160, 120).z()), 0.5, 1e-3);
  EXPECT_NEAR(view.inputs.ambient(160, 120), 0.1 * 0.2 * 0.3 / M_PI, 1e-4);
}

}  // namespace
}  // namespace cousin
