// Devices whose numbers the fit does not know, and models that it must reject.
#include "benchmarks/tools/fit_sensor/hidden_device.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "benchmarks/tools/fit_sensor/rounding.h"

namespace cousin {
namespace {

using testing::HasSubstr;

SensorFit fit_of(const RecordedFrames& frames, const HiddenDevice& device,
                 const RecordingPlan& plan) {
  return fit_frames(frames, geometry_of(device, plan), rig_choice("d457"), "a hidden device");
}

/// Fewer and smaller frames than a user would take, for time.
RecordingPlan quick_plan() {
  RecordingPlan plan;
  plan.distances_m = {0.6, 0.85, 1.2, 1.7, 2.4};
  plan.frames = 6;
  plan.flats = 0;
  return plan;
}

std::string problems_of(const SensorFit& fit) {
  std::string all;
  for (const std::string& p : fit.problems) all += p + "\n";
  return all;
}

TEST(HiddenDevice, ItsNumbersLieInTheIntervalsAsOftenAsTheySay) {
  int inside = 0, all = 0;
  RecordingPlan plan = quick_plan();
  plan.flats = 6;
  for (std::uint64_t i = 0; i < 8; ++i) {
    const Rng rng = Rng(21).fork(i);
    const HiddenDevice device = draw_hidden_device("d457", rng);
    const SensorFit fit = fit_of(record(device, plan, rng), device, plan);
    EXPECT_EQ(problems_of(fit), "") << i;
    for (const HiddenParameter& p : hidden_parameters(device, fit)) {
      inside += is_inside(p);
      ++all;
      // Four half widths are eight standard errors.
      const double half = 0.5 * (p.estimate.high - p.estimate.low);
      EXPECT_NEAR(p.estimate.value, p.truth, 4 * half) << i << " " << p.name;
    }
    for (const HeldOut& h : fit.depth->held_out) EXPECT_NEAR(h.ratio, 1, 0.1) << i << " " << h.wall;
  }
  EXPECT_GE(all, 8 * 14);
  // 95 % of 120 numbers, less three standard errors of the count (2 % each).
  EXPECT_GE(inside, 0.89 * all);
}

TEST(HiddenDevice, ItsPresetIsReadByThePresetsReaderAndKeepsWhatWasNotFitted) {
  const Rng rng(3);
  const HiddenDevice device = draw_hidden_device("d457", rng);
  const SensorFit fit = fit_of(record(device, quick_plan(), rng), device, quick_plan());
  ASSERT_EQ(problems_of(fit), "");
  ActiveStereoConfig fitted;
  read_toml_text(fit.preset_toml, "fitted", fields(fitted), MissingKeys::error);
  const ActiveStereoConfig preset = active_stereo_preset("d457");
  EXPECT_EQ(fitted.match.block_px, preset.match.block_px);
  EXPECT_EQ(fitted.model.grain_px, preset.model.grain_px);
  EXPECT_NE(fitted.model.spatial_px, preset.model.spatial_px);
  EXPECT_THAT(fit.preset_toml, HasSubstr("# fitted: to a hidden device"));
}

TEST(WrongModel, NoiseThatGrowsAsTheDistanceIsRejected) {
  RecordingPlan plan = quick_plan();
  plan.noise_exponent = 1;
  const Rng rng(4);
  HiddenDevice device = draw_hidden_device("d457", rng);
  device.spatial_exponent = device.temporal_exponent = 0;
  const SensorFit fit = fit_of(record(device, plan, rng), device, plan);
  EXPECT_THAT(problems_of(fit), HasSubstr("stereo grows as Z^2"));
  EXPECT_NEAR(fit.depth->sigma_z_exponent.value, 1, 0.05);
  EXPECT_EQ(fit.preset_toml, "");
}

TEST(WrongModel, AWallThatBendsIsRejected) {
  RecordingPlan plan = quick_plan();
  plan.bend_m = 0.02;  // over the whole view; a quarter of it within the region
  const Rng rng(5);
  const HiddenDevice device = draw_hidden_device("d457", rng);
  const SensorFit fit = fit_of(record(device, plan, rng), device, plan);
  EXPECT_THAT(problems_of(fit), HasSubstr("bends: RMS"));
  EXPECT_EQ(fit.preset_toml, "");
}

TEST(WrongModel, DistancesInAnotherUnitAreRejected) {
  const RecordingPlan plan = quick_plan();
  const Rng rng(6);
  const HiddenDevice device = draw_hidden_device("d457", rng);
  DepthGeometry geometry = geometry_of(device, plan);
  geometry.depth_unit_m *= 0.8;
  const SensorFit fit =
      fit_frames(record(device, plan, rng), geometry, rig_choice("d457"), "another unit");
  EXPECT_THAT(problems_of(fit), HasSubstr("times the stated distances: depth_unit_m"));
}

TEST(WrongModel, AUnitThatNobodyMentionsIsNamedAsTheLikelyReason) {
  const RecordingPlan plan = quick_plan();
  const Rng rng(6);
  const HiddenDevice device = draw_hidden_device("d457", rng);
  const RecordedFrames frames = record(device, plan, rng);
  for (const double factor : {10.0, 4.0, 2.0, 0.5, 0.2, 0.1}) {
    DepthGeometry geometry = geometry_of(device, plan);
    const double true_unit_m = geometry.depth_unit_m;
    geometry.depth_unit_m *= factor;
    const SensorFit fit = fit_frames(frames, geometry, rig_choice("d457"), "another unit");
    EXPECT_THAT(problems_of(fit), HasSubstr("times the stated distances: depth_unit_m")) << factor;
    char told[64];
    std::snprintf(told, sizeof told, "depth_unit_m = %g)", true_unit_m);
    EXPECT_THAT(problems_of(fit), HasSubstr(told)) << factor;
    EXPECT_EQ(fit.preset_toml, "");
  }
}

TEST(WrongModel, APausedStreamIsNoRecording) {
  const RecordingPlan plan = quick_plan();
  const Rng rng(7);
  const HiddenDevice device = draw_hidden_device("d457", rng);
  RecordedFrames frames = record(device, plan, rng);
  for (WallFrames& wall : frames.walls) {
    wall.frame = [first = wall.frame(0)](int) { return first; };
  }
  const SensorFit fit = fit_of(frames, device, plan);
  EXPECT_THAT(problems_of(fit), HasSubstr("frames are all alike"));
  EXPECT_THAT(problems_of(fit), HasSubstr("at least 4 are needed"));
}

TEST(RoundedVariance, IsThatOfRoundedNormals) {
  // Both roundings as a device does them: 1/32 px, then a depth's unit.
  constexpr double kFirst = 1.0 / 32, kSecond = 0.05;
  for (const double sigma : {0.01, 0.03, 0.08}) {
    Rng rng(8);
    double sum = 0;
    constexpr int kPlaces = 4000, kDraws = 50;
    for (int i = 0; i < kPlaces; ++i) {
      const double at = uniform(rng, 0, 100);
      double mean = 0, squares = 0;
      for (int k = 0; k < kDraws; ++k) {
        const double once = std::round((at + sigma * normal(rng)) / kFirst) * kFirst;
        const double twice = std::round(once / kSecond) * kSecond;
        mean += twice / kDraws;
        squares += twice * twice / kDraws;
      }
      sum += (squares - mean * mean) * kDraws / (kDraws - 1.0);
    }
    const double expected = rounded_variance(sigma, kFirst, kSecond);
    // The mean over 4000 places, whose variances differ by about half of it: 0.8 %; allow four.
    EXPECT_NEAR(sum / kPlaces / expected, 1, 0.035) << sigma;
  }
  EXPECT_DOUBLE_EQ(rounded_variance(0.2, 0, 0), 0.2 * 0.2);
  EXPECT_NEAR(rounded_variance(0.2, 0.01, 0), 0.04 + 1e-4 / 12, 1e-12);
}

TEST(PowerLaw, FindsAnExponentAndWidensForMisfit) {
  std::vector<PowerPoint> points;
  for (const double z : {0.5, 1.0, 2.0, 4.0})
    points.push_back({z, {0.07 * std::pow(z, 0.3), 0.001}});
  const PowerLaw law = fit_power_law(points, 1);
  EXPECT_NEAR(std::exp(law.log_value), 0.07, 1e-12);
  EXPECT_NEAR(law.exponent, 0.3, 1e-12);
  points[1].value.value *= 1.2;  // 14 of its standard errors
  const PowerLaw off = fit_power_law(points, 1);
  EXPECT_GT(off.chi2, 50);
  EXPECT_GT(off.covariance(1, 1), 10 * law.covariance(1, 1));
  EXPECT_THROW(fit_power_law({points[0]}, 1), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
