#include "sim/sensors/depth_model.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <tuple>

#include "sim/sensors/fast_normal.h"
#include "sim/sensors/match_contrast.h"
#include "sim/sensors/noise_grain.h"
#include "tests/sim/sensors/depth_test_scenes.h"

namespace cousin {
namespace {

using test::add_plate;
using test::even_sky;
using test::infrared_grey;
using test::small_depth_camera;

/// f B of the small camera.
constexpr double kFocalBaseline = 192 * 0.095;

/// A wall that fills the image.
DepthModelInputs wall(double z_m, float albedo = 0.5F) {
  DepthModelInputs inputs;
  inputs.depth_m = Image<float>(320, 240, static_cast<float>(z_m));
  inputs.normal = Image<Eigen::Vector3f>(320, 240, Eigen::Vector3f(0, 0, -1));
  inputs.albedo = Image<float>(320, 240, albedo);
  inputs.ambient = Image<float>(320, 240, 0.001F);
  inputs.hidden = Image<std::uint8_t>(320, 240, std::uint8_t{0});
  return inputs;
}

/// Noise of known size at every light.
ActiveStereoConfig plain_model(double spatial_px, double temporal_px, double fill = 1) {
  ActiveStereoConfig config = small_depth_camera();
  DepthModelConfig& m = config.model;
  m.spatial_px = {spatial_px, spatial_px};
  m.temporal_px = {temporal_px, temporal_px};
  m.spatial_wave = m.temporal_wave = m.ripple_px = m.fill_wave = {0, 0};
  m.contrast = {0, 4};
  const double score = fill <= 0 ? -10 : fill >= 1 ? 10 : normal_quantile(fill);
  m.fill_score = {score, score};
  m.slope_spatial = m.slope_temporal = m.slope_fill = m.bias_px = m.fatten_px = m.rim_px =
      m.band_px = 0;
  return config;
}

struct Spread {
  double n = 0, mean = 0, sigma = 0;
};
/// Of depth over x0 .. x1 and all rows.
Spread spread_of(const ModelDepth& depth, const ActiveStereoConfig& config, int x0, int x1) {
  double n = 0, sum = 0, squares = 0;
  for (int y = 0; y < depth.depth.height(); ++y) {
    for (int x = x0; x < x1; ++x) {
      if (depth.depth(x, y) == 0) continue;
      const double z = depth.depth(x, y) * config.depth_unit_m;
      n += 1;
      sum += z;
      squares += z * z;
    }
  }
  return {n, sum / n, std::sqrt(std::max(0.0, squares / n - sum / n * (sum / n)))};
}

TEST(DepthModel, SpreadFollowsTheSquareOfDepth) {
  ActiveStereoConfig config = plain_model(0.08, 0);
  config.depth_unit_m = 1e-4;
  config.model.grain_px = 3;
  for (const double z : {0.5, 1.0, 2.0}) {
    const Spread s = spread_of(model_depth(wall(z), config, Rng(1), Rng(2)), config, 100, 320);
    // sigma_d, with what rounding to 1/32 px adds. 220 * 240 / 9 independent draws: 0.9 % each.
    const double sigma_px = std::hypot(0.08, 1 / 32.0 / std::sqrt(12.0));
    EXPECT_NEAR(s.sigma / (z * z * sigma_px / kFocalBaseline), 1, 0.04) << z;
    EXPECT_NEAR(s.mean, z, 3 * s.sigma / std::sqrt(5000.0) + 2e-4) << z;
  }
}

TEST(DepthModel, SpatialNoiseStaysAndTemporalNoiseGoesFromImageToImage) {
  const ActiveStereoConfig fixed_only = plain_model(0.1, 0);
  EXPECT_EQ(model_depth(wall(1), fixed_only, Rng(1), Rng(2)).depth,
            model_depth(wall(1), fixed_only, Rng(1), Rng(3)).depth);
  ActiveStereoConfig both = plain_model(0.1, 0.1);
  both.disparity_step_px = 0;
  const ModelDepth a = model_depth(wall(1), both, Rng(1), Rng(2));
  const ModelDepth b = model_depth(wall(1), both, Rng(1), Rng(3));
  double n = 0, squares = 0;
  for (std::size_t i = 0; i < a.disparity_px.size(); ++i) {
    const double d = a.disparity_px.data()[i] - b.disparity_px.data()[i];
    if (std::isnan(d)) continue;
    n += 1;
    squares += d * d;
  }
  // Twice the temporal variance; 320 * 240 / 25 independent draws or so: 2 % each.
  EXPECT_NEAR(std::sqrt(squares / n / 2), 0.1, 0.008);
}

TEST(DepthModel, FillIsTheShareAsked) {
  for (const double fill : {0.0, 0.3, 0.9, 1.0}) {
    ActiveStereoConfig config = plain_model(0.05, 0.02, fill);
    config.model.grain_px = 3;
    const Spread s = spread_of(model_depth(wall(1), config, Rng(1), Rng(2)), config, 40, 320);
    EXPECT_NEAR(s.n / (280 * 240), fill, 0.02) << fill;
  }
}

TEST(DepthModel, NoLightIsNoDepthAndNoTexture) {
  ActiveStereoConfig config = plain_model(0.1, 0.1);
  config.has_projector = false;
  const ModelDepth depth = model_depth(wall(1), config, Rng(1), Rng(2));
  EXPECT_EQ(depth.depth(200, 100), 0);
  EXPECT_EQ(depth.reason(200, 100), InvalidReason::no_texture);
}

TEST(DepthModel, RippleGoesWithTheFractionOfTheDisparity) {
  ActiveStereoConfig config = plain_model(0, 0);
  config.disparity_step_px = 0;
  config.model.ripple_px = {0.05, 0.05};
  for (const double d : {18.0, 18.25, 18.5, 18.75}) {
    const ModelDepth depth = model_depth(wall(kFocalBaseline / d), config, Rng(1), Rng(2));
    EXPECT_NEAR(depth.disparity_px(200, 100), d + 0.05 * std::sin(2 * M_PI * d), 1e-4) << d;
  }
}

TEST(DepthModel, NoiseAndFillGoWithTheFractionOfTheDisparity) {
  ActiveStereoConfig config = plain_model(0.1, 0, 0.5);
  config.disparity_step_px = 0;
  config.model.grain_px = 3;
  config.model.spatial_wave = {0.4, 0.4};
  config.model.fill_wave = {1, 1};
  for (const auto& [d, sigma_px, fill] :
       {std::tuple{18.0, 0.14, 0.8413}, {18.25, 0.1, 0.5}, {18.5, 0.06, 0.1587}}) {
    const ModelDepth depth = model_depth(wall(kFocalBaseline / d), config, Rng(1), Rng(2));
    double n = 0, squares = 0;
    for (int y = 0; y < 240; ++y) {
      for (int x = 40; x < 320; ++x) {
        if (std::isnan(depth.disparity_px(x, y))) continue;
        n += 1;
        squares += std::pow(double(depth.disparity_px(x, y)) - d, 2);
      }
    }
    // 7500 grains of 9 pixels: 0.6 points of a half; at a sixth filled, 2 % of a sigma.
    EXPECT_NEAR(n / (280 * 240), fill, 0.02) << d;
    EXPECT_NEAR(std::sqrt(squares / n) / sigma_px, 1, 0.09) << d;
  }
}

TEST(DepthModel, AWaveDiesWhereAWindowSpansAWholePixel) {
  for (const float slope : {0.0F, 0.02F, 0.05F, 0.08F}) {
    const double t = M_PI * 11 * static_cast<double>(slope);
    EXPECT_NEAR(wave_share(slope, 11), t > 0 ? std::sin(t) / t : 1, 0.02) << slope;
  }
  EXPECT_EQ(wave_share(0.1F, 11), 0);
}

TEST(MatchContrast, KnowsSignalFromNoiseByTheMargin) {
  const ActiveStereoConfig config = small_depth_camera();
  PatternLight light;
  light.still_e2 = 40;
  light.margin_e = 60;
  const MatchContrast contrast(config, light, 0.5, 2);
  EXPECT_EQ(contrast(0, 100), 0);
  EXPECT_GT(contrast(400, 100), contrast(100, 100));
  EXPECT_GT(contrast(200, 100), contrast(200, 4000));
  // A margin above the noise leaves even places empty: windows differ by dots alone.
  light.margin_e = 5;
  EXPECT_GT(contrast(300, 1000), MatchContrast(config, light, 0.5, 2)(300, 1000));
  // Noise alone sets the same bits anywhere: the ratio of p (1 - p) to itself.
  EXPECT_NEAR(MatchContrast(config, light, 0.5, 2)(0.05F, 4000), 0, 0.02);
}

TEST(DepthModel, TheBandAndTheRangeAreThoseOfTheDisparity) {
  const ActiveStereoConfig config = plain_model(0, 0);
  const ModelDepth depth = model_depth(wall(0.6), config, Rng(1), Rng(2));  // 30.4 px
  EXPECT_EQ(depth.reason(30, 100), InvalidReason::band);
  EXPECT_EQ(depth.reason(31, 100), InvalidReason::none);
  const ModelDepth near = model_depth(wall(0.14), config, Rng(1), Rng(2));
  EXPECT_EQ(near.reason(200, 100), InvalidReason::out_of_range);
  const ModelDepth far = model_depth(wall(25), config, Rng(1), Rng(2));
  EXPECT_EQ(far.reason(200, 100), InvalidReason::out_of_range);
}

TEST(DepthModel, OcclusionIsAsWideAsTheDifferenceOfDisparities) {
  const ActiveStereoConfig config = plain_model(0, 0);
  DepthModelInputs inputs = wall(1.2);  // 15.2 px
  for (int y = 60; y < 180; ++y) {
    for (int x = 120; x < 200; ++x) inputs.depth_m(x, y) = 0.5F;  // 36.48 px
  }
  inputs.hidden = stereo_occlusion(inputs.depth_m, config);
  int right = 0, projector = 0;
  for (int x = 0; x < 320; ++x) {
    right += (inputs.hidden(x, 100) & kHiddenFromRight) ? 1 : 0;
    projector += (inputs.hidden(x, 100) & kHiddenFromProjector) ? 1 : 0;
  }
  EXPECT_NEAR(right, 36.48 - 15.2, 1);
  EXPECT_NEAR(projector, (36.48 - 15.2) * config.projector_x_m / config.baseline_m, 1);
  const ModelDepth depth = model_depth(inputs, config, Rng(1), Rng(2));
  EXPECT_EQ(depth.reason(110, 100), InvalidReason::left_right);
  EXPECT_EQ(depth.reason(110, 20), InvalidReason::none);
}

TEST(DepthModel, NearSurfacesGrowAndWearARim) {
  ActiveStereoConfig config = plain_model(0, 0);
  config.model.fatten_px = 3;
  config.model.rim_px = 2;
  DepthModelInputs inputs = wall(1.2);
  for (int y = 60; y < 180; ++y) {
    for (int x = 120; x < 200; ++x) inputs.depth_m(x, y) = 0.5F;
  }
  const ModelDepth depth = model_depth(inputs, config, Rng(1), Rng(2));
  EXPECT_EQ(depth.depth(202, 100), 500);  // 200 .. 202 are taken
  EXPECT_EQ(depth.reason(203, 100), InvalidReason::mixed_pixel);
  EXPECT_EQ(depth.reason(204, 100), InvalidReason::mixed_pixel);
  EXPECT_NEAR(depth.depth(205, 100), 1200, 2);  // a step of disparity is 2.5 mm
  EXPECT_EQ(depth.depth(160, 182), 500);
}

TEST(DepthModel, RenderedInputsAreTheScenes) {
  const ActiveStereoConfig config = small_depth_camera();
  Scene scene;
  add_plate(scene, 1.2, -4, -4, 4, 4, infrared_grey(0.4F));
  add_plate(scene, 0.5, -0.1, -0.15, 0.1, 0.15, infrared_grey(0.7F));
  scene.lights.emplace_back(even_sky(0.5));
  const RayScene rays(scene);
  const ActiveStereoUnit unit = make_active_stereo(config, Rng(1));
  const DepthModelInputs inputs =
      depth_model_inputs(rays, scene, test::rig_looking_along_x(), config, unit, Rng(2));
  EXPECT_NEAR(inputs.depth_m(160, 120), 0.5, 1e-6);
  EXPECT_NEAR(inputs.depth_m(20, 20), 1.2, 1e-6);
  EXPECT_EQ(inputs.albedo(160, 120), 0.7F);
  EXPECT_EQ(inputs.albedo(20, 20), 0.4F);
  // An even sky of irradiance 0.5, its infrared share 0.2: 0.5 * 0.2 * albedo / pi.
  EXPECT_NEAR(inputs.ambient(20, 20), 0.5 * 0.2 * 0.4 / M_PI, 1e-4);
  EXPECT_NEAR(inputs.normal(160, 120).z(), -1, 1e-6);
  EXPECT_TRUE(inputs.hidden(110, 120) & kHiddenFromRight);
}

TEST(DepthModel, MoreLightOnThePatternIsMoreSignal) {
  const ActiveStereoConfig config = small_depth_camera();
  const auto contrast = [&](const DepthModelInputs& inputs) {
    const PatternLight light = pattern_light(inputs, config);
    return MatchContrast(config, light, 1, 2)(light.signal_e(200, 100), light.ambient_e(200, 100));
  };
  EXPECT_GT(contrast(wall(2)), contrast(wall(4)));
  EXPECT_GT(contrast(wall(4, 0.6F)), contrast(wall(4, 0.1F)));
  DepthModelInputs sunny = wall(2);
  for (float& v : sunny.ambient) v = 0.3F;
  EXPECT_GT(contrast(wall(2)), contrast(sunny));
}

TEST(DepthModel, GivesTheSameBytesForAnyNumberOfThreads) {
  const ActiveStereoConfig config = small_depth_camera();
  const auto with_threads = [&](std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    return model_depth(wall(2), config, Rng(1), Rng(2));
  };
  const ModelDepth one = with_threads(1);
  EXPECT_EQ(one.depth, with_threads(2).depth);
  EXPECT_EQ(one.reason, with_threads(7).reason);
}

TEST(DepthModel, RejectsWhatDoesNotFit) {
  ActiveStereoConfig config = small_depth_camera();
  DepthModelInputs inputs = wall(1);
  inputs.albedo = Image<float>(3, 3);
  EXPECT_THROW(model_depth(inputs, config, Rng(1), Rng(2)), std::invalid_argument);
  config.model.fill_score.pop_back();
  EXPECT_THROW(model_depth(wall(1), config, Rng(1), Rng(2)), std::invalid_argument);
  config = small_depth_camera();
  config.model.contrast[1] = config.model.contrast[0];
  EXPECT_THROW(validate(config.model), std::invalid_argument);
}

TEST(NoiseGrain, HasUnitVarianceAndIsAlikeOverItsGrain) {
  const Image<float> noise = noise_grain(400, 300, 7, Rng(5));
  double squares = 0, beside = 0, apart = 0, n = 0;
  for (int y = 0; y < 300; ++y) {
    for (int x = 0; x + 10 < 400; ++x) {
      n += 1;
      squares += noise(x, y) * noise(x, y);
      beside += noise(x, y) * noise(x + 3, y);
      apart += noise(x, y) * noise(x + 10, y);
    }
  }
  // 117000 / 49 independent draws: the variance is known to 3 %.
  EXPECT_NEAR(squares / n, 1, 0.12);
  EXPECT_NEAR(beside / n, 4.0 / 7, 0.1);  // means of 7 share 4 columns
  EXPECT_NEAR(apart / n, 0, 0.1);
}

TEST(NoiseGrain, NormalShareIsTheDistributionFunction) {
  for (const float x : {-3.0F, -1.0F, 0.0F, 0.5F, 2.5F})
    EXPECT_NEAR(normal_share(x), 0.5 * std::erfc(-x / std::sqrt(2.0)), 1e-6) << x;
}

}  // namespace
}  // namespace cousin
